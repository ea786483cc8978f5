"""Graph variables, which nodes of a graph read and write by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from graphengine.format.errors import ContextError
from graphengine.format.stateful import Stateful
from graphengine.format.wording import did_you_mean, listing
from graphengine.node import types

T = TypeVar("T")


class Variable(Stateful):
    """A variable of a graph.

    Attributes:
        value: value that was written last; the default if none was written since the start of play.
        default: value before the first tick and after a stop.
    """

    __slots__ = ("_before", "_now", "default", "value")

    kept = ("_before", "_now", "value")

    def __init__(self, default: Any) -> None:
        self.default = self.value = self._before = self._now = default

    @property
    def changed(self) -> bool:
        """Whether the value at the start of this tick differs from the value at the start of the previous tick."""
        return not types.equal(self._before, self._now)

    def freeze(self) -> None:
        """Begin a tick: store the current value, which `changed` compares with the value stored one tick earlier."""
        self._before, self._now = self._now, self.value

    def clear(self) -> None:
        """Reset the value to the default."""
        self.value = self._before = self._now = self.default


def find_variable(variables: Mapping[str, T], name: str) -> T:
    """Return the variable of a graph with this name.

    Raises:
        ContextError: the graph has no variable of this name.
    """
    if name not in variables:
        near = did_you_mean(name, variables) or listing(variables, "variables")
        raise ContextError(f"the graph has no variable {name!r}", name, near)
    return variables[name]
