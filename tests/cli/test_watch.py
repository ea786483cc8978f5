"""`graphrun run --watch` and `graphrun ctl reload`: files change while a process of its own runs them."""

from __future__ import annotations

import json
import re
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.conftest import CLOCK
from tests.cli.harness import Graphrun, Live, live, process

WORLD = '<mujoco><worldbody><geom type="plane" size="5 5 .1"/></worldbody></mujoco>'
SCENE = """format: 1
scene: hall
world: world.xml
graphs:
  mine: {use: mine.yaml}
"""
MEMORY = ("--transport", "memory")


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No run of others is in the folder of the sockets."""
    with tempfile.TemporaryDirectory(prefix="graphrun-test-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield


@pytest.fixture
def hall(project: Path) -> Path:
    (project / "world.xml").write_text(WORLD, encoding="utf-8")
    (project / "hall.yaml").write_text(SCENE, encoding="utf-8")
    return project


def expect(run: Live, text: str) -> None:
    assert run.hear(lambda said: text in said), run.said


def test_a_watched_run_reloads_changed_files_and_prints_the_changes(hall: Path, graphrun: Graphrun) -> None:
    with live("run", "hall.yaml", "--watch", "--rate", "realtime", "--record", "out.mcap", *MEMORY, cwd=hall) as run:
        expect(run, " Hz, ")
        (hall / "mine.yaml").write_text(CLOCK.replace("topicName: clock", "topicName: other"), encoding="utf-8")
        expect(run, "mine.yaml changed: exchanged mine; 3 of 3 nodes keep their state\n")
        (hall / "mine.yaml").write_text(CLOCK.replace("topicName", "topicNam"), encoding="utf-8")
        expect(run, "mine.yaml:8:14: error G204: ROS2PublishClock has no input 'topicNam'\n")
        expect(
            run, "  did you mean 'topicName'?\n1 error in changed files; the run continues with the previous version\n"
        )
        (hall / "mine.yaml").write_text(CLOCK, encoding="utf-8")
        expect(run, "mended: mine.yaml changed: exchanged mine; 3 of 3 nodes keep their state\n")
        (hall / "world.xml").write_text(WORLD.replace("5 5", "6 6"), encoding="utf-8")
        expect(run, "world.xml changed: the world changed; restarted at t = 0\n")
        assert run.stop(signal.SIGINT) == 0
    replayed = process("replay", "out.mcap", cwd=hall, code=0)
    assert replayed.out.startswith("identical: ")
    assert "Traceback" not in run.said


def test_a_paused_run_reloads_changed_files(hall: Path) -> None:
    with live("run", "hall.yaml", "--watch", "--paused", *MEMORY, cwd=hall) as run:
        expect(run, " Hz, ")
        (hall / "mine.yaml").unlink()
        expect(run, "error S101: graph 'mine': no file 'mine.yaml'")
        (hall / "mine.yaml").write_text(CLOCK, encoding="utf-8")
        expect(run, "mended: mine.yaml changed: graphs and world are unchanged\n")
        assert run.stop(signal.SIGTERM) == 0


def test_without_watch_a_run_keeps_its_files_until_it_is_asked_to_reload(hall: Path, graphrun: Graphrun) -> None:
    with live("run", "hall.yaml", "--paused", *MEMORY, cwd=hall) as run:
        expect(run, " Hz, ")
        (hall / "mine.yaml").write_text(CLOCK.replace("topicName: clock", "topicName: other"), encoding="utf-8")
        result = graphrun("ctl", "reload", code=0)
        assert result.lines[0] == "mine.yaml changed: exchanged mine; 3 of 3 nodes keep their state"
        assert re.fullmatch(r"hall \(process \d+\): paused, t = 0\.000 s, rate max", result.lines[1])
        (hall / "mine.yaml").write_text("nonsense: 1\n", encoding="utf-8")
        refused = graphrun("ctl", "reload", code=1)
        assert "mine.yaml:1:1: error G106" in refused.err
        assert graphrun("ctl", "state", code=0).lines[1:] == [
            "  2 errors in changed files; the run continues with the previous version"
        ]
        (hall / "mine.yaml").write_text(CLOCK, encoding="utf-8")
        assert json.loads(graphrun("ctl", "reload", "--json", code=0).out)["changed"] == ["mine"]
        assert run.stop(signal.SIGINT) == 0
