"""What nodes do, written down in the order they do it."""

from __future__ import annotations

from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, Node


class Journaling(Node):
    """Base of nodes that write down what they do."""

    journal: Publisher = Bound()
    me: str = Bound()

    def setup(self, context: Context) -> None:
        self.journal = context.publisher("std_msgs/msg/String", "journal")
        self.me = context.prim_path.rpartition("/")[2]

    def write(self, *words: object) -> None:
        self.journal.publish(" ".join([self.me, *(f"{w:g}" if isinstance(w, float) else str(w) for w in words)]))
