"""The base class of nodes that read their graph's clock."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, Node


class ClockNode(Node):
    """Base of nodes that read their graph's clock, bound as `clock`."""

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock
