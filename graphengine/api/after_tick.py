"""The base class of what a session does after each tick."""

from __future__ import annotations

from abc import abstractmethod

from graphengine.format.stateful import Stateful


class AfterTick(Stateful):
    """Something that a session does after each tick; checkpoints contain its state."""

    @abstractmethod
    def after_tick(self, frame: int) -> None:
        """Act if it is time; `frame` is the number of ticks since the start or since the last reset of the time."""
