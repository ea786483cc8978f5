"""Keys held down on a run's terminal, for its graphs.

A terminal sends a character when a key goes down and again and again while it is held, but nothing when it goes up. So a key
counts as let go when nothing came for longer than a terminal waits before the first repetition.
"""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING

from graphengine.cli.terminal_keyboard import ENDS, TerminalKeyboard
from graphengine.node.keys import keys_of
from graphengine.runtime.commands import Press, Release

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

RELEASE_AFTER = 0.6
"""Seconds of wall time; a common wait before the first repetition is 0.5 s (X11 0.66 s, Linux console 0.25 s)."""


class HeldTerminalKeys(TerminalKeyboard):
    """The terminal's keys, as long as a run goes on.

    Raises:
        UsageError: the standard input is no terminal.
    """

    def __init__(self) -> None:
        super().__init__(signals=True)
        self._last: dict[tuple[str, ...], float] = {}

    def on_tick(self, session: SessionCore) -> None:
        """Press what was pressed, and let go of what is no longer repeated."""
        now = monotonic()
        for character in self.pressed(0.0):
            keys = keys_of(character)
            if not keys or character in ENDS:
                continue
            if keys not in self._last:
                Press(keys=keys).apply(session)
            self._last[keys] = now
        for keys, last in list(self._last.items()):
            if now - last > RELEASE_AFTER:
                del self._last[keys]
                released = tuple(key for key in keys if not any(key in others for others in self._last))
                if released:
                    Release(keys=released).apply(session)
