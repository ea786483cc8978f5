"""Values from wires that nodes could not use, counted by node."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from graphengine.format.stateful import Stateful

BadValues = Literal["drop", "stop"]
"""Policy for values from wires that a node cannot use: drop them, or end the run."""


@dataclass(slots=True)
class DroppedValues(Stateful):
    """Counts the ticks in which each node dropped a value.

    Attributes:
        ticks: number of such ticks, by prim path of the node.
    """

    kept = ("ticks", "_latest")

    ticks: dict[str, int] = field(default_factory=dict)
    _latest: dict[str, int] = field(default_factory=dict)

    def add(self, node: str, tick: int) -> bool:
        """Count a value that a node dropped in a tick.

        Returns:
            Whether to warn: true in the node's first, second, fourth, eighth, … tick with a dropped value.
        """
        if self._latest.get(node) == tick:
            return False
        self._latest[node] = tick
        count = self.ticks[node] = self.ticks.get(node, 0) + 1
        return count & (count - 1) == 0
