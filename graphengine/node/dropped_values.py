"""Counts the bad values that nodes dropped: values from wires and messages, and values set while the session ran."""

from __future__ import annotations

from dataclasses import dataclass, field

from graphengine.format.stateful import Stateful


@dataclass(slots=True)
class DroppedValues(Stateful):
    """Counts, for each node, the ticks in which the node dropped a value.

    Attributes:
        ticks: number of ticks with a dropped value, by prim path of the node.
        drops_set_values: whether values that were set while the session ran are dropped too, not only values from wires; false in
            replays of older recordings.
    """

    kept = ("ticks", "_latest")

    ticks: dict[str, int] = field(default_factory=dict)
    drops_set_values: bool = True
    _latest: dict[str, int] = field(default_factory=dict)

    def add(self, node: str, tick: int) -> bool:
        """Count a tick in which a node dropped a value, and return whether to warn about it.

        Several values in the same tick count once. A warning is due in a node's first, second, fourth, eighth, … counted tick.
        """
        if self._latest.get(node) == tick:
            return False
        self._latest[node] = tick
        count = self.ticks[node] = self.ticks.get(node, 0) + 1
        return count & (count - 1) == 0

    def earlier(self, node: str) -> str:
        """Return the end of a due warning, such as `, as in 3 of the ticks before`; empty for the first warning of a node."""
        before = self.ticks[node] - 1
        return f", as in {before} of the ticks before" if before else ""
