"""What comes into a session from outside beside messages."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, Protocol


class Inbox(Protocol):
    """Where a session reads it: a recorder takes it down, a replay brings it again."""

    @property
    def exact(self) -> bool:
        """Whether a tick waits for its pictures at any pace, so that another run gets the same."""

    def begin_tick(self) -> float:
        """The wall clock (s since 1970) that nodes read in the tick which begins."""

    def end_tick(self) -> None:
        """A tick is over, and its messages were sent."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """The session was asked for something that changes its course, and did it; the next tick is the first to know.

        Args:
            name: of the session's method.
            arguments: as JSON has them.
        """


class LiveInbox:
    """The wall clock of this machine."""

    exact = False

    def begin_tick(self) -> float:
        """The time."""
        return time.time()

    def end_tick(self) -> None:
        """Nothing is kept."""

    def command(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Nothing is kept."""
