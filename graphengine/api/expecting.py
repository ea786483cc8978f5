"""Checks that a session makes after each tick, such as the expectations of `graphengine.experiments`."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

from graphengine.api.runner import AfterTick

Outcome = Literal["open", "passed", "failed", "error"]
"""`open`: not decided yet; `error`: the check could not be made, for example because a topic had no messages."""


class Check(AfterTick):
    """A statement about a run that is judged after each tick. `Session.expect` starts the judgement and returns the check."""

    @property
    @abstractmethod
    def outcome(self) -> Outcome:
        """The outcome so far."""

    @abstractmethod
    def end(self) -> None:
        """Decide the outcome at the end of the run. Safe to call twice."""

    @abstractmethod
    def report(self) -> str:
        """Return the outcome, the statement, the time of the decision, and the robustness."""
