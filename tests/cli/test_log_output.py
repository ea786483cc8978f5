"""What packages log reaches the terminal without control characters and in a bounded length."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.cli.log_output import LONGEST
from tests.cli.harness import environment

PROGRAM = """import logging, sys
from graphengine.cli import main
def log(*arguments):
    for name in ("websockets.server", "asyncio", "foxglove.channels", "rosout"):
        logging.getLogger(name).warning("from %s: %s", name, sys.argv[1] + "x" * 100_000)
    try:
        raise ValueError(sys.argv[1])
    except ValueError:
        logging.getLogger("viser").exception("failed")
    logging.getLogger("websockets.server").info("not shown")
import graphengine.cli.topics as verb
verb.execute = lambda arguments: log() or 0
sys.exit(main(["topics", "x"]))
"""


@pytest.mark.parametrize("text", ["\x1b[2J\x1b[31mred", "\x07\x08\x9b31m", "\u202egnp.exe", "\r\nerror: the run"])
def test_a_text_of_a_stranger_in_a_log_cannot_control_the_terminal(text: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, text], env=environment(), cwd=tmp_path, capture_output=True, check=True
    )
    said = done.stderr.decode()
    assert "from websockets.server: " in said
    assert "from foxglove.channels: " in said
    assert "ValueError: " in said
    assert "not shown" not in said
    assert all(character.isprintable() or character == "\n" for character in said)
    assert len(said) < 6 * LONGEST
