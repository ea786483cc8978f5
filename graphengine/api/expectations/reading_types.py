"""The types of readings, which are the values of a session that conditions read."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from graphengine.format.stateful import Stateful

Shared = tuple[str, Callable[[], Any]]
"""A unique name and a function: a value that several readings share, which is read once per tick."""
Kind = Literal["number", "vector", "other"]
"""`number` is a bool, int or float, `vector` a tuple or a one-dimensional array of numbers."""


class ReadingState(Stateful):
    """The state of a reading between ticks; checkpoints contain it."""

    @abstractmethod
    def reset(self) -> None:
        """Restart at the current time, after a reset of the time."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A value of the session that an expression reads.

    Attributes:
        read: returns the current value, given the values of `of`; None if there is no value yet, for example because no message
            has arrived on a topic.
        kind: kind of the value.
        field: returns the reading of a number or vector in a record, given its path such as `twist.linear.x`; None if the record
            does not have it.
        state: state between ticks; None for a reading without state.
        arrives: whether the value depends on the messages since the reading was made: it may be missing, and conditions do not
            share it.
        of: values from which the value is computed.
    """

    read: Callable[..., Any]
    kind: Kind = "number"
    field: Callable[[str], Reading | None] = lambda path: None
    state: ReadingState | None = None
    arrives: bool = False
    of: Sequence[Shared] = ()

    @property
    def value(self) -> Any:
        """The current value, or None."""
        return self.read(*(read() for _, read in self.of))


Readings = Mapping[str, Callable[..., Reading]]
"""Functions that expressions can call, by name; each takes the constant arguments of a call and returns the reading."""
