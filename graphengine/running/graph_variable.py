"""A variable of a running graph."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from graphengine import types
from graphengine.diagnostics import ContextError, did_you_mean, listing

T = TypeVar("T")


def find_variable(variables: Mapping[str, T], name: str) -> T:
    """What is known of a graph's variable, by its name.

    Raises:
        ContextError: the graph has none of that name.
    """
    if name not in variables:
        near = did_you_mean(name, variables) or listing(variables, "variables")
        raise ContextError(f"the graph has no variable {name!r}", name, near)
    return variables[name]


class GraphVariable:
    """A graph's variable and what it was when the last two ticks began."""

    __slots__ = ("_before", "_now", "default", "value")

    def __init__(self, default: Any) -> None:
        self.default = self.value = self._before = self._now = default

    @property
    def changed(self) -> bool:
        """Whether it changed during the last tick."""
        return not types.equal(self._before, self._now)

    def freeze(self) -> None:
        """Begin a tick."""
        self._before, self._now = self._now, self.value

    def clear(self) -> None:
        """Back to the default."""
        self.value = self._before = self._now = self.default
