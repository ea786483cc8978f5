"""The status line of a run, on terminals that are really there."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path

import pytest

from tests.cli.harness import Graphrun, live
from tests.cli.screen import frames, shown
from tests.waiting import PATIENCE

MEMORY = ("--transport", "memory")
TERMINAL = {"TERM": "xterm-256color", "NO_COLOR": ""}
FACTS = [
    r"t \d+\.\d\d s",
    r"x\d+\.\d\d",
    r"\d+ late",
    r"\d+ messages/s",
    r"\d+ subscribers",
    r"\d+ dropped",
    r"\d+\.\d\d ms a tick",
]
STATUS = re.compile("  ".join(FACTS[:2]) + ".*")
SUMMARY = re.compile(r"\d+ ticks, [\d.]+ s of simulation in .* messages?")

NOISY = '''
import sys
import warnings

from graphengine.node import ExecIn, Node, State


class Noisy(Node, type="term.Noisy"):
    """Prints in many ways while it runs."""

    exec_in = ExecIn()
    count: int = State(default=0)

    def compute(self) -> None:
        self.count += 1
        if self.count == 35:
            print("to the standard output")
        if self.count == 36:
            print("a long line to the standard error", "word " * 30 + "end", file=sys.stderr)
        if self.count == 37:
            warnings.warn("something is odd", stacklevel=1)
        if self.count == 90 and "broken" in __file__:
            raise ValueError("this node is broken")
'''
GRAPH = """
graph: noisy
nodes:
  Tick: OnPlaybackTick
  Noisy: term.Noisy
connections:
  - Tick.tick -> Noisy.execIn
"""


def noise(folder: Path, module: str) -> tuple[str, ...]:
    """The arguments of a run in real time with a node that prints."""
    (folder / f"{module}.py").write_text(NOISY, encoding="utf-8")
    (folder / "noisy.yaml").write_text(GRAPH, encoding="utf-8")
    return ("run", "noisy.yaml", "--import", module, "--rate", "realtime", *MEMORY)


def statuses(said: str) -> list[str]:
    """The status lines, one written over the other."""
    return [frame for frame in frames(said) if STATUS.fullmatch(frame)]


@pytest.mark.parametrize(("columns", "least"), [(200, 7), (80, 5), (40, 3), (20, 2)])
def test_the_status_line_has_the_facts_that_fit_and_is_cleared_at_the_end(columns: int, least: int) -> None:
    with live("run", "dd100_flat", "--rate", "realtime", *MEMORY, columns=columns, env=TERMINAL) as run:
        assert run.hear(lambda said: len(statuses(said)) > 2)
        assert run.stop(signal.SIGINT) == 0, run.said
    for line in statuses(run.said):
        facts = line.split("  ")
        assert len(line) < columns
        assert least <= len(facts) <= len(FACTS)
        for pattern, fact in zip(FACTS, facts, strict=False):
            assert re.fullmatch(pattern, fact)
    *screen, summary, end = shown(run.said, 10_000)
    assert not any(STATUS.search(line) for line in screen)
    assert SUMMARY.fullmatch(summary)
    assert end == ""


def test_other_output_is_printed_above_the_status_line_in_order(tmp_path: Path) -> None:
    arguments = (*noise(tmp_path, "noisy"), "--for", "1.2s")
    with live(*arguments, cwd=tmp_path, columns=80, env=TERMINAL, out=True) as run:
        run.hear(lambda said: False)
        assert run.process.wait(PATIENCE) == 0
    assert statuses(run.said)
    first, *screen, summary, _ = shown(run.said, 10_000)
    assert first.startswith("noisy.yaml: 60 Hz, ")
    assert screen[0] == "to the standard output"
    assert screen[1].split() == ["a", "long", "line", "to", "the", "standard", "error", *["word"] * 30, "end"]
    assert screen[2].endswith("UserWarning: something is odd")
    assert [line for line in screen[3:] if not line.startswith("  warnings.warn(")] == []
    assert SUMMARY.fullmatch(summary)


def test_an_error_that_ends_the_run_is_the_last_line_after_the_status_line(tmp_path: Path) -> None:
    with live(*noise(tmp_path, "broken"), cwd=tmp_path, columns=80, env=TERMINAL, out=True) as run:
        run.hear(lambda said: False)
        assert run.process.wait(PATIENCE) == 1
    screen = shown(run.said, 10_000)
    assert not any(STATUS.search(line) for line in screen)
    assert "raised ValueError: this node is broken" in " ".join(" ".join(screen).split()), screen
    assert any(line.startswith("error: ") for line in screen), screen
    assert screen[-1] == ""


def test_the_cursor_is_there_whenever_a_run_may_be_killed() -> None:
    with live("run", "dd100_flat", "--rate", "realtime", *MEMORY, columns=80, env=TERMINAL) as run:
        assert run.hear(lambda said: len(statuses(said)) > 2)
        run.process.kill()
        run.hear(lambda said: False)
    assert run.said.replace("\x1b[?25l\x1b[?25h", "").count("\x1b[?25l") == 0


def test_a_terminal_that_is_closed_does_not_end_the_run() -> None:
    with live("run", "dd100_flat", "--rate", "realtime", "--for", "1500ms", *MEMORY, columns=80, env=TERMINAL) as run:
        assert run.hear(lambda said: len(statuses(said)) > 2)
        terminal, run._reading = run._reading, os.open(os.devnull, os.O_RDONLY)
        os.close(terminal)
        assert run.process.wait(PATIENCE) == 0


@pytest.mark.parametrize("term", ["dumb", "unknown"])
def test_a_terminal_that_cannot_overwrite_gets_plain_lines(term: str) -> None:
    run_ = ("run", "dd100_flat", "--rate", "realtime", "--for", "600ms", *MEMORY)
    with live(*run_, columns=80, env={"TERM": term}) as run:
        run.hear(lambda said: False)
        assert run.process.wait(PATIENCE) == 0
    assert "\x1b" not in run.said
    assert len(run.said.splitlines()) == 3


def test_no_color_leaves_the_colours_out(tmp_path: Path) -> None:
    arguments = ("run", "dd100_flat", "--rate", "realtime", "--record", str(tmp_path / "a.mcap"), *MEMORY)
    with live(*arguments, columns=120, env=TERMINAL) as run:  # a recording's size is red
        assert run.hear(lambda said: "REC" in said)
        run.stop(signal.SIGINT)
    assert "\x1b[31m" in run.said
    with live(*arguments, "--force", columns=120, env={**TERMINAL, "NO_COLOR": "1"}) as run:
        assert run.hear(lambda said: "REC" in said)
        run.stop(signal.SIGINT)
    assert not re.search(r"\x1b\[[0-9;]*3[0-9]", run.said)


def test_a_quiet_run_prints_only_warnings(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.cli.console.Console.PLAIN", 0.0)
    assert graphrun("run", "dd100_flat", "--for", "100ms", "--quiet", *MEMORY, code=0, out="").err == ""
    result = graphrun("run", "tutorial/flat_grid", "--for", "100ms", "--quiet", *MEMORY, code=0, out="")
    assert "warning W201" in result.err
    assert "ticks" not in result.err
    assert "60 Hz" not in result.err
