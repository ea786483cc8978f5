"""The command line of `graphrun test`."""

from __future__ import annotations

import sys

import pytest

from graphengine.cli import main


@pytest.mark.parametrize(
    "arguments", [["--nope"], ["--resume"], ["--rerun", "0"], ["--results", "x.jsonl", "-n", "no"]]
)
def test_a_wrong_command_line_has_the_exit_code_of_pytest(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="4"):
        sys.exit(main(["test", *arguments]))
    assert "graphrun test: " in capsys.readouterr().err


def test_processes_without_xdist_are_refused_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "xdist", None)
    assert main(["test", "-n", "2"]) == 4
    assert "graphrun test: -n needs pytest-xdist; install it with: pip install" in capsys.readouterr().err
