"""Events, with which passes begin."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, ExecOut, Fire, In, Mailbox, Node, Out, Pushes, State


class Tick(Node, type="test.Tick"):
    """Fires every pass."""

    tick = ExecOut()
    number: float = Out()
    time: float = Out()

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        self.clock = context.clock

    def compute(self) -> None:
        self.number += 1.0
        self.time = self.clock.time


class Every(Node, type="test.Every", gated=True):
    """Fires in every n-th pass."""

    n: int = In(default=2)
    fired = ExecOut()

    passes: int = State(default=0)

    def compute(self) -> Fire:
        self.passes += 1
        return self.fired if self.passes % self.n == 0 else None


class TwoEnds(Node, type="test.TwoEnds"):
    """Fires even or odd, by the number of the pass."""

    even = ExecOut()
    odd = ExecOut()

    passes: int = State(default=0)

    def compute(self) -> Fire:
        self.passes += 1
        return self.odd if self.passes % 2 else self.even


class OnImpulse(Node, type="test.OnImpulse", gated=True):
    """Fires once in a tick before which somebody posted, however often."""

    name: str = In(default="impulse", setup=True)
    fired = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        self.mailbox = context.mailbox(self.name)

    def compute(self) -> Fire:
        return self.fired if self.mailbox.take() else None


class OnMessage(Node, type="test.OnMessage"):
    """Runs what follows once for each item that was posted before the tick."""

    name: str = In(default="messages", setup=True)
    received = ExecOut()
    done = ExecOut()
    value: float = Out()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        self.mailbox = context.mailbox(self.name)

    def compute(self) -> Pushes:
        for item in self.mailbox.take():
            self.value = item
            yield self.received
        yield self.done
