"""Interface between a session and its recorder or replay for external inputs: wall clock, commands and reloaded files."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from graphengine.format.files import Files


class ExternalInputs:
    """Gives a session the wall clock of this machine, and records nothing; the recorder and the replay are subclasses."""

    exact = False
    """Whether each tick waits for its camera images, even in a run with a pace, so that a replay gets the same images."""

    replays = False
    """Whether the inputs come from a recording; values that a recorded command sets need not be within the bounds of ports."""

    @property
    def recorded_bytes(self) -> int | None:
        """Size of the recording without data in buffers, bytes; None if nothing is recorded."""
        return None

    def begin_tick(self) -> float:
        """Begin a tick; return the wall clock time that nodes read in it, s since 1970."""
        return time.time()

    def end_tick(self) -> None:
        """End a tick; the session calls this after it has sent the messages of the tick."""

    def reading(self, files: Files) -> None:
        """Receive the files of a reload before it takes effect; called again if a file changed while the files were read."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Receive a command that affects the simulation, after it was executed; it takes effect in the next tick.

        Args:
            name: name of the command.
            arguments: arguments as JSON values.
        """
