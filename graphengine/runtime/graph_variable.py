"""A variable of a running graph."""

from __future__ import annotations

from typing import Any

from graphengine.node import types


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
