"""What nodes have in common that read the clock of their graph."""

from __future__ import annotations

from graphengine.node import Clock, Context, Node, State


class ClockNode(Node):
    """A node that reads the clock."""

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock
