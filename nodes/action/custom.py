"""Nodes that send and receive named events (`omni.graph.action`). An event sent in one tick is received in the next tick."""

from __future__ import annotations

from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Mailbox, Node, Out, Pushes, Token


class CustomEventNode(Node):
    """Base of nodes that send or receive the events named `eventName`."""

    event_name: Token = In(default="", setup=True)

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Create a mailbox on the queue of the events named `eventName`."""
        self.mailbox = context.mailbox(f"event:{self.event_name}")


class SendCustomEvent(CustomEventNode, type="omni.graph.action.SendCustomEvent"):
    """Sends an event to all OnCustomEvent nodes with the same `eventName`, in all graphs of the session."""

    exec_in = ExecIn()
    bundle: Any = In(type="bundle", doc="bundle sent with the event")
    path: Token = In(default="", doc="path sent with the event")
    exec_out = ExecOut()

    def compute(self) -> None:
        """Post the event to its queue; the receivers get it in the next tick."""
        self.mailbox.post((self.bundle, self.path))


class OnCustomEvent(CustomEventNode, type="omni.graph.action.OnCustomEvent"):
    """Fires once for each event named `eventName` that was sent in the previous tick."""

    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    exec_out = ExecOut()
    bundle: Any = Out(type="bundle", doc="bundle sent with the event")
    path: Token = Out(doc="path sent with the event")

    def compute(self) -> Pushes:
        """For each event of the previous tick, set the outputs and yield `execOut`."""
        for bundle, path in self.mailbox.take():
            self.bundle, self.path = bundle, path
            yield self.exec_out
