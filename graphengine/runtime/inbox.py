"""External inputs of a session other than messages: the wall clock, commands and reloaded files."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from graphengine.format.files import Files


class ExternalInputs:
    """Reads the wall clock of this machine and records nothing. The recorder and the replay are subclasses."""

    exact = False
    """Whether ticks wait for camera images at any pace, so that a replay gets the same images."""

    @property
    def recorded_bytes(self) -> int | None:
        """Size of the recording without buffered data, bytes; None if nothing is recorded."""
        return None

    def begin_tick(self) -> float:
        """Return the wall clock time (s since 1970) that nodes read in the tick that begins."""
        return time.time()

    def end_tick(self) -> None:
        """Called at the end of a tick, after its messages were sent."""

    def reading(self, files: Files) -> None:
        """Called with the files that a reload has read, before the reload takes effect, and again if a file changes meanwhile."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Called after a command that affects the simulation was executed; it takes effect in the next tick.

        Args:
            name: name of the command.
            arguments: arguments as JSON values.
        """
