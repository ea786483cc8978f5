"""`graphrun view`: the page of a recording, its end, and recordings that cannot be looked at."""

from __future__ import annotations

import re
import signal
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

from tests.cli.harness import Graphrun, live
from tests.recording.harness import CLOCK, put, record, rewritten


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_recording_is_served_until_a_signal_and_compared_as_replay_does(
    graphrun: Graphrun, clock: Path, number: signal.Signals
) -> None:
    path, folder = clock.parent / "out.mcap", clock.parent / "temporary"
    folder.mkdir()
    record(path, 30, clock)
    verdict = graphrun("replay", str(path), code=0).out
    with live("view", str(path), env={"TMPDIR": str(folder)}) as viewed:
        assert viewed.hear(lambda said: said.endswith(verdict))
        assert re.fullmatch(r"see it: http://127\.0\.0\.1:\d+/#token=\S+\n" + re.escape(verdict), viewed.said)
        assert list(folder.iterdir()) != []
        assert viewed.stop(number) == 0
    assert viewed.said.endswith(verdict)
    assert list(folder.iterdir()) == []


def test_view_reports_a_difference_of_the_replay_with_the_text_of_the_command_replay(
    graphrun: Graphrun, clock: Path
) -> None:
    path = clock.parent / "out.mcap"
    record(path, 30, clock)
    other = rewritten(path, manifest={"overrides": '{"Clock.topicName": "time"}'})
    first = graphrun("replay", str(other), code=1).lines[0]
    with live("view", str(other)) as viewed:
        assert viewed.hear(lambda said: f"{first}\n  the recording has no such message\n" in said)


def test_a_recording_that_was_cut_off_is_reported(clock: Path) -> None:
    path = clock.parent / "out.mcap"
    record(path, 200, clock)
    data = path.read_bytes()
    path.write_bytes(data[: data.index(b"graphengine:end") - 20])
    with live("view", str(path)) as viewed:
        assert viewed.hear(lambda said: "the run was cut off: the recording ends at t = " in said)


def test_a_file_that_is_no_recording_is_one_error(graphrun: Graphrun, tmp_path: Path) -> None:
    path = put(tmp_path / "out.mcap", "scene: a\n")
    graphrun("view", str(path), code=2, out="", err=f"graphrun view: {path}: not an MCAP file\n")


def test_modules_that_a_recording_names_are_imported_only_if_an_option_names_them(
    graphrun: Graphrun, clock: Path
) -> None:
    path = clock.parent / "out.mcap"
    record(path, 3, clock, modules=["strange_nodes"])
    result = graphrun("view", str(path), code=2, out="")
    assert "if you trust these modules, give --import strange_nodes" in result.err


def test_errors_of_a_scene_end_the_verb(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    record(path, 3, put(tmp_path / "hall" / "graph.yaml", CLOCK))
    other = rewritten(path, manifest={"overrides": '{"Clock.queueSize": "many"}'})
    assert "queueSize" in graphrun("view", str(other), code=1, out="").err


def test_a_taken_port_is_reported(graphrun: Graphrun, clock: Path) -> None:
    path = clock.parent / "out.mcap"
    record(path, 3, clock)
    result = graphrun("view", str(path), "--view-host", "localhost", code=2)
    assert "'localhost' is not an IP address; write one such as 127.0.0.1" in result.err


def test_a_recording_is_written_as_one_file_with_the_verdict_of_its_replay(graphrun: Graphrun, clock: Path) -> None:
    path, written = clock.parent / "out.mcap", clock.parent / "page.html"
    record(path, 30, clock)
    verdict = graphrun("replay", str(path), code=0).out
    result = graphrun("view", str(path), "--html", str(written), code=0, err=verdict)
    size = written.stat().st_size
    assert result.out.endswith(f"page.html: {size / 1e6:.1f} MB\n")
    assert size < 800_000


def test_a_file_that_is_no_page_is_not_overwritten(graphrun: Graphrun, clock: Path) -> None:
    path = clock.parent / "out.mcap"
    record(path, 3, clock)
    before = path.read_bytes()
    result = graphrun("view", str(path), "--html", str(path), code=2, out="")
    assert "the name must end in .html; files with other endings are not overwritten" in result.err
    assert path.read_bytes() == before


def test_a_page_that_cannot_be_written_is_one_error(graphrun: Graphrun, clock: Path) -> None:
    path = clock.parent / "out.mcap"
    record(path, 3, clock)
    result = graphrun("view", str(path), "--html", str(clock / "page.html"), code=None, out="")
    assert result.err.count("\n") <= 3
    assert str(clock) in result.err
    assert "Traceback" not in result.err
