"""Passes keys that the user presses in the terminal of a run to its graphs.

A terminal sends a character when a key is pressed, and repeats the character while the key is held, but does not report the
release of a key. So a key counts as released if its character has not arrived for `RELEASE_AFTER`.
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
"""Wall time without a repeated character after which a key counts as released, s.

The common delay before the first repetition is 0.5 s (X11 0.66 s, Linux console 0.25 s).
"""


class HeldTerminalKeys(TerminalKeyboard):
    """Passes the keys pressed in the terminal to a session.

    Raises:
        UsageError: the standard input is not a terminal.
    """

    def __init__(self) -> None:
        super().__init__(signals=True)
        self._last: dict[tuple[str, ...], float] = {}

    def on_tick(self, session: SessionCore) -> None:
        """Press keys whose characters arrived since the last call; release keys whose characters are no longer repeated."""
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
