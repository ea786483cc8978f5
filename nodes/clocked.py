"""ClockNode, the base class of nodes that read the simulation clock of their graph."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, Node


class ClockNode(Node):
    """Base of nodes that read the simulation clock of their graph. `setup` stores the clock in `clock`."""

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Store the clock of the node's graph in `clock`."""
        self.clock = context.clock
