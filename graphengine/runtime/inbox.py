"""What comes into a session from outside, beside messages."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from graphengine.format.files import Files


class ExternalInputs:
    """Reads the wall clock of this machine, and keeps nothing. A recorder and a replay extend it."""

    exact = False
    """Whether a tick waits for its pictures at any pace, so that another run gets the same."""

    @property
    def recorded_bytes(self) -> int | None:
        """Size of the recording without buffered data, bytes; None if nothing is recorded."""
        return None

    def begin_tick(self) -> float:
        """The wall clock (s since 1970) that nodes read in the tick which begins."""
        return time.time()

    def end_tick(self) -> None:
        """Called when a tick is over, and its messages were sent."""

    def reading(self, files: Files) -> None:
        """Take the files that a reload has read; called before the reload takes effect, and again if a file changes meanwhile."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Called when a command that changes the simulation's course was carried out; the next tick is the first after it.

        Args:
            name: of the command.
            arguments: as JSON has them.
        """
