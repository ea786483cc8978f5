"""Nodes that cannot use some values; of those called Picky, one of each kind that drops every third of its values."""

from __future__ import annotations

from graphengine.format.errors import BadValueError, TopicError
from graphengine.node import Context, ExecIn, ExecOut, Fire, In, Node, Out, Pushes, State, String
from tests.compiler.nodes_for_tests.journal import Journaling


class Picky(Journaling):
    """Base of nodes that take two values and drop the third."""

    tries: int = State(default=0)

    def taste(self) -> None:
        """Raise at every third try; what is wrong came from outside of the node's inputs."""
        self.tries += 1
        if self.tries % 3 == 0:
            raise BadValueError("outside", self.tries)


class PickyAdd(Picky, type="test.PickyAdd"):
    """Sum of two numbers."""

    a: float = In(default=0.0)
    b: float = In(default=0.0)
    sum: float = Out()

    def compute(self) -> None:
        self.taste()
        self.sum = self.a + self.b


class PickyTick(Picky, type="test.PickyTick"):
    """Fires in two of three passes."""

    tick = ExecOut()
    number: float = Out()

    def compute(self) -> None:
        self.taste()
        self.number += 1.0


class PickyDo(Picky, type="test.PickyDo"):
    """Writes down what it read."""

    exec_in = ExecIn()
    a: float = In(default=0.0)
    exec_out = ExecOut()
    shown: float = Out()

    def compute(self) -> None:
        self.taste()
        self.shown = self.a
        self.write(self.a)


class PickyChoice(Picky, type="test.PickyChoice"):
    """Fires one way or the other."""

    exec_in = ExecIn()
    a: float = In(default=0.0)
    low = ExecOut()
    high = ExecOut()

    def compute(self) -> Fire:
        self.taste()
        return self.high if self.a > 1.0 else self.low


class PickyCounter(Picky, type="test.PickyCounter", counts=True):
    """Counts activations; a reset comes before what arrives with it."""

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True)
    exec_out = ExecOut()
    count: float = Out()

    def compute(self) -> None:
        self.taste()
        self.count = 0.0 if self.reset_in else self.count + self.exec_in
        self.write(f"in={self.exec_in} reset={self.reset_in} count={self.count:g}")


class PickyLoop(Picky, type="test.PickyLoop"):
    """Fires three times, or drops a value between two of them."""

    exec_in = ExecIn()
    body = ExecOut()
    finished = ExecOut()
    index: float = Out()

    def compute(self) -> Pushes:
        for index in range(3):
            self.taste()
            self.index = float(index)
            yield self.body
            self.tries += index
        yield self.finished


class PickyDelay(Picky, type="test.PickyDelay"):
    """Fires at its third update; drops values when it is executed, and when it is updated."""

    exec_in = ExecIn()
    finished = ExecOut()
    updates: float = Out()

    def compute(self) -> None:
        self.taste()
        self.active = True
        self.updates = 0.0

    def update(self) -> Fire:
        self.taste()
        self.updates += 1.0
        self.active = self.updates < 2.0
        return None if self.active else self.finished


class Refuses(Node, type="test.Refuses"):
    """Cannot use one value, nor those from another one on."""

    exec_in = ExecIn()
    value: float = In(default=0.0)
    bad: float = In(default=-1.0)
    since: float = In(default=1e9, name="from")
    exec_out = ExecOut()
    shown: float = Out()

    def compute(self) -> None:
        if self.value == self.bad or self.value >= self.since:
            raise BadValueError("value", self.value)
        self.shown = self.value


class RefusesZero(Node, type="test.RefusesZero"):
    """One over a number."""

    value: float = In(default=1.0)
    result: float = Out()

    def compute(self) -> None:
        if not self.value:
            raise BadValueError("value", self.value)
        self.result = 1.0 / self.value


class Announces(Journaling, type="test.Announces"):
    """Opens a topic in setup, of which one is refused as the network does."""

    exec_in = ExecIn()
    topic: String = In(default="", setup=True)
    forbidden: String = In(default="")
    exec_out = ExecOut()

    def setup(self, context: Context) -> None:
        super().setup(context)
        if self.topic == self.forbidden:
            raise TopicError("no such topic", self.topic)

    def compute(self) -> None:
        self.write("sends on", self.topic)
