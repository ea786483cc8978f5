"""Reads single key presses from the terminal, and restores the terminal's settings afterwards."""

from __future__ import annotations

import contextlib
import os
import re
import select
import sys
import termios
from collections.abc import Iterator
from typing import Any, Self

from graphengine.format.errors import UsageError

ENDS = ("\x03", "\x04")
"""Keys that end the reading: Ctrl-C and Ctrl-D. A closed terminal counts as Ctrl-D."""

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_KEY = re.compile(r"\x1b[\[O][0-9;]*([A-Za-z~])|(.)", re.DOTALL)
"""Matches the text that a terminal sends for one key: an escape sequence or a character."""


class TerminalKeyboard:
    """Reads keys from the terminal; as a context manager, it turns off echo and line buffering.

    Args:
        signals: whether Ctrl-C interrupts the program; otherwise it is returned as a key.

    Raises:
        UsageError: the standard input is not a terminal.
    """

    def __init__(self, *, signals: bool = False) -> None:
        if sys.stdin is None or not sys.stdin.isatty():
            raise UsageError(
                "keys are read from a terminal, but the standard input is not one\n"
                "  scripts publish velocities with `graphrun topic pub -r 10 /cmd_vel geometry_msgs/Twist …`"
            )
        self._file = sys.stdin.fileno()
        self._left_out = termios.ECHO | termios.ICANON | (0 if signals else termios.ISIG)
        self._before: list[Any] = []

    def __enter__(self) -> Self:
        self._before = termios.tcgetattr(self._file)
        changed = termios.tcgetattr(self._file)
        changed[3] &= ~self._left_out
        termios.tcsetattr(self._file, termios.TCSADRAIN, changed)
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(termios.error):  # of a terminal that is gone
            termios.tcsetattr(self._file, termios.TCSAFLUSH, self._before)

    def pressed(self, timeout: float) -> list[str]:
        """Return the keys pressed since the last call; if there are none, wait up to `timeout` s for one.

        Each key is returned as its character, an arrow as `up`, `down`, `left` or `right`, another special key as an empty text.
        """
        ready, _, _ = select.select([self._file], [], [], timeout)
        if not ready:
            return []
        try:
            text = os.read(self._file, 1024).decode("utf-8", "replace")
        except OSError:
            text = ""
        return list(_keys(text)) if text else [ENDS[1]]


def _keys(text: str) -> Iterator[str]:
    for match in _KEY.finditer(text):
        yield _ARROWS.get(match[1], "") if match[1] else match[2]
