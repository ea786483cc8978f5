"""The context in which the steps of a scenario are executed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from graphengine.api.session import Session
from graphengine.experiments.programs import Programs


@dataclass
class StepContext:
    """The session and the programs of one run of a scenario.

    Attributes:
        session: the session.
        programs: the programs that steps start.
        ending: for each publication with a duration, the time at which it ends, s, and the function that ends it.
    """

    session: Session
    programs: Programs
    ending: list[tuple[float, Callable[[], None]]] = field(default_factory=list)

    def end_publications(self) -> None:
        """End the publications whose time has come."""
        now = self.session.time + 1e-9
        for entry in [entry for entry in self.ending if entry[0] <= now]:
            entry[1]()
            self.ending.remove(entry)
