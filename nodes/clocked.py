"""The base of nodes that read the clock of their graph."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, Node


class ClockNode(Node):
    """Base of nodes that read the clock."""

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock
