"""Events by name, from one node to others (`omni.graph.action`); seen in the tick after the one in which they were sent."""

from __future__ import annotations

from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Mailbox, Node, Out, Pushes, Token


class SendCustomEvent(Node, type="omni.graph.action.SendCustomEvent"):
    """Sends an event to every OnCustomEvent of its name, in whatever graph of the session."""

    exec_in = ExecIn()
    bundle: Any = In(type="bundle", doc="goes along")
    event_name: Token = In(default="", setup=True)
    path: Token = In(default="", doc="a text that goes along")
    exec_out = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Bind the queue of the name."""
        self.mailbox = context.mailbox(f"event:{self.event_name}")

    def compute(self) -> None:
        """Send."""
        self.mailbox.post((self.bundle, self.path))


class OnCustomEvent(Node, type="omni.graph.action.OnCustomEvent"):
    """Fires for each event of its name that was sent in the tick before, one after the other."""

    event_name: Token = In(default="", setup=True)
    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    exec_out = ExecOut()
    bundle: Any = Out(type="bundle", doc="what came along")
    path: Token = Out(doc="the text that came along")

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Bind the queue of the name."""
        self.mailbox = context.mailbox(f"event:{self.event_name}")

    def compute(self) -> Pushes:
        """Event by event."""
        for bundle, path in self.mailbox.take():
            self.bundle, self.path = bundle, path
            yield self.exec_out
