"""Interface for the external inputs of a session, between session and recorder or replay: wall clock, commands, reloads."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from graphengine.format.files import Files


class ExternalInputs:
    """Gives a session the wall clock of this machine, and records nothing; the recorder and the replay are subclasses."""

    exact = False
    """Whether each tick waits for its camera images, even in a run with a pace: a replay then gets the same images."""

    replays = False
    """Whether the inputs come from a recording; values that a recorded command sets may exceed the bounds of ports."""

    @property
    def recorded_bytes(self) -> int | None:
        """Size of the recording without buffered data, bytes; None without a recording."""
        return None

    def begin_tick(self) -> float:
        """Begin a tick; return the wall clock time that nodes read in the tick, s since 1970."""
        return time.time()

    def end_tick(self) -> None:
        """End a tick; the session calls this method after it has sent the messages of the tick."""

    def reading(self, files: Files) -> None:
        """Receive the files of a reload before the reload takes effect; called again if a file changed during the reading."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Receive an executed command that affects the simulation from the next tick on.

        Args:
            name: name of the command.
            arguments: arguments as JSON values.
        """
