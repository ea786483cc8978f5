"""The interface of checks of a run, which `Session.expect` begins, such as those of the expectations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal

from graphengine.api.after_tick import AfterTick

Outcome = Literal["open", "passed", "failed", "error"]
"""`open`: not decided yet; `error`: the check could not be made, for example because a topic had no messages."""


class Check(ABC):
    """A statement about a run that is judged after each tick. `Session.expect` begins the judgement and returns the check."""

    @property
    @abstractmethod
    def outcome(self) -> Outcome:
        """The outcome so far."""

    @abstractmethod
    def begin(self, actions: dict[object, AfterTick]) -> None:
        """Begin the judgement; `actions` contains the actions of the session after each tick, in their order."""

    @abstractmethod
    def stop(self, actions: dict[object, AfterTick]) -> None:
        """Stop the judgement. Safe to call twice."""

    @abstractmethod
    def end(self) -> None:
        """Decide the outcome at the end of the run. Safe to call twice."""

    @abstractmethod
    def report(self) -> str:
        """Return the outcome, the statement, the time of the decision, and the robustness."""
