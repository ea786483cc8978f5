"""Progress bars of verbs that take a while, on terminals that are really there."""

from __future__ import annotations

import re
import sys
import threading
from pathlib import Path

import pytest

from graphengine.cli import progress as bars
from graphengine.cli.progress import progress
from tests.cli.harness import live, process
from tests.cli.screen import frames, shown
from tests.physics.pictures.harness import needs_opengl
from tests.waiting import PATIENCE

TERMINAL = {"TERM": "xterm-256color"}
AT_ONCE = "from graphengine.cli import progress; progress.DELAY = 0.0; progress.PERIOD = 0.01\n"
"""As a module that a verb imports, it lets bars appear from the start."""


@pytest.mark.parametrize("columns", [80, 30])
def test_a_replay_shows_the_share_of_the_recording_as_progress(drive: Path, tmp_path: Path, columns: int) -> None:
    (tmp_path / "at_once.py").write_text(AT_ONCE, encoding="utf-8")
    arguments = ("replay", str(drive), "--import", "at_once")
    with live(*arguments, cwd=tmp_path, columns=columns, env=TERMINAL, out=True) as run:
        run.hear(lambda said: False)
        assert run.process.wait(PATIENCE) == 0, run.said
    found = [frame for frame in frames(run.said) if frame.startswith("replaying ")]
    shares = [int(match[1]) for frame in found if (match := re.search(r"(\d+) %", frame))]
    assert shares
    assert shares == sorted(shares)
    assert max(map(len, found)) <= columns
    lines = [line for line in shown(run.said, 10_000) if line and not line.startswith("compiling the rays")]
    assert [line.partition(":")[0] for line in lines] == ["identical"]


@needs_opengl
def test_a_snapshot_of_a_later_time_shows_the_progress_of_the_simulation(tmp_path: Path) -> None:
    (tmp_path / "at_once.py").write_text(AT_ONCE, encoding="utf-8")
    run_ = ("snapshot", "dd100_flat", "--at", "5s", "--size", "64x48", "-o", "out.png", "--rays", "mujoco")
    with live(*run_, "--import", "at_once", cwd=tmp_path, columns=80, env=TERMINAL) as run:
        run.hear(lambda said: False)
        assert run.process.wait(PATIENCE) == 0, run.said
    bars = {frame.split()[0] for frame in frames(run.said) if "━" in frame}
    assert bars == {"loading", "simulating"}
    assert shown(run.said, 10_000)[-2].startswith("out.png: ")


def test_without_a_terminal_no_bar_is_drawn(drive: Path, tmp_path: Path) -> None:
    (tmp_path / "at_once.py").write_text(AT_ONCE, encoding="utf-8")
    arguments = ("replay", str(drive), "--import", "at_once")
    result = process(*arguments, cwd=tmp_path, env={**TERMINAL, "FORCE_COLOR": "1"}, code=0)
    assert "\x1b" not in result.err
    assert "replaying" not in result.err
    assert result.out.startswith("identical: ")


def test_long_work_without_a_terminal_prints_its_share_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bars, "PLAIN", 0.001)
    seen = threading.Event()

    def done() -> float:
        seen.set()
        return 0.5

    with progress("local\u202eizing", done, 2.0):
        assert seen.wait(PATIENCE)
    assert set(capsys.readouterr().err.splitlines()) == {"local\ufffdizing: 25 %"}


def test_fast_work_shows_no_bar_and_imports_no_rich(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.cli.terminal.can_overwrite", lambda: True)
    monkeypatch.setitem(sys.modules, "rich.progress", None)
    with progress("working"):
        pass


def test_the_error_of_the_work_is_raised_and_the_bar_ends(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("graphengine.cli.terminal.can_overwrite", lambda: True)
    monkeypatch.setattr(bars, "DELAY", 0.0)
    seen: list[float] = []

    def done() -> float:
        seen.append(0.5)
        return 0.5

    def work() -> None:
        while not seen:
            pass
        raise ValueError("the work failed")

    with pytest.raises(ValueError, match="the work failed"), progress("working", done, 1.0):
        work()
    written = capsys.readouterr().err
    assert "working" in written
    assert [line for line in shown(written, 10_000) if line] == []
