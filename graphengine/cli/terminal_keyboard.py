"""Single key presses from a terminal, whose settings are restored afterwards."""

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
"""Ctrl-C, and Ctrl-D or a terminal that is gone."""

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_KEY = re.compile(r"\x1b[\[O][0-9;]*([A-Za-z~])|(.)", re.DOTALL)
"""What a terminal sends for a key: an escape sequence, or a character."""


class TerminalKeyboard:
    """A terminal without echo and line buffering, in which Ctrl-C is an ordinary key.

    Args:
        signals: let Ctrl-C send its signal.

    Raises:
        UsageError: the standard input is not a terminal.
    """

    def __init__(self, *, signals: bool = False) -> None:
        if sys.stdin is None or not sys.stdin.isatty():
            raise UsageError("keys are read from a terminal, but the standard input is not one")
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
        """Return the keys pressed since the last call, waiting up to `timeout` s for one: characters, and names for arrows."""
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
