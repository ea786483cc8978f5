"""Actions: what is executed and fires what follows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Mailbox, Node, Out, State, String, Variable
from tests.compiler.nodes_for_tests.journal import Journaling


class Do(Journaling, type="test.Do"):
    """Adds two numbers and writes the sum down."""

    exec_in = ExecIn()
    a: float = In(default=0.0)
    b: float = In(default=0.0)
    exec_out = ExecOut()
    sum: float = Out()

    def compute(self) -> None:
        self.sum = self.a + self.b
        self.write(self.sum)


class Sum(Node, type="test.Sum"):
    """Adds two numbers."""

    exec_in = ExecIn()
    a: float = In(default=0.0)
    b: float = In(default=0.0)
    exec_out = ExecOut()
    sum: float = Out()

    def compute(self) -> None:
        self.sum = self.a + self.b


class Show(Journaling, type="test.Show"):
    """Writes down a value of any type."""

    exec_in = ExecIn()
    value: Any = In(type="any")
    exec_out = ExecOut()

    def compute(self) -> None:
        self.write(self.value)


class Branch(Journaling, type="test.Branch"):
    """Fires one of two."""

    exec_in = ExecIn()
    condition: bool = In(default=False)
    exec_true = ExecOut()
    exec_false = ExecOut()

    def compute(self) -> Fire:
        self.write(self.condition)
        return self.exec_true if self.condition else self.exec_false


class Choose(Node, type="test.Choose"):
    """Fires one, the other, both or none, by the bits of a number."""

    exec_in = ExecIn()
    bits: int = In(default=0)
    first = ExecOut()
    second = ExecOut()

    def compute(self) -> Fire:
        return self.bits


class Door(Node, type="test.Door", gated=True):
    """Fires when open."""

    exec_in = ExecIn()
    open: bool = In(default=True)
    exec_out = ExecOut()

    def compute(self) -> Fire:
        return self.exec_out if self.open else None


class Join(Journaling, type="test.Join"):
    """Writes down which of its inputs fired, and how often."""

    first = ExecIn()
    second = ExecIn()
    hold = ExecIn(control=True)
    value: float = In(default=0.0)
    exec_out = ExecOut()

    def compute(self) -> None:
        self.write(f"first={self.first} second={self.second} hold={self.hold}")


class Counter(Journaling, type="test.Counter", counts=True):
    """Counts activations; a reset comes before what arrives with it."""

    exec_in = ExecIn()
    second = ExecIn()
    reset_in = ExecIn(name="reset", control=True)
    step: float = In(default=1.0)
    exec_out = ExecOut()
    count: float = Out()

    def compute(self) -> None:
        if self.reset_in:
            self.count = 0.0
        if self.exec_in or self.second:
            self.count += self.step
        self.write(f"in={self.exec_in} second={self.second} reset={self.reset_in} count={self.count:g}")


class Gate(Journaling, type="test.Gate", counts=True, gated=True):
    """Lets through what enters while open; toggle opens and closes."""

    enter = ExecIn()
    toggle = ExecIn(control=True)
    exit_out = ExecOut(name="exit")

    open: bool = State(default=False)

    def compute(self) -> Fire:
        if self.toggle:
            self.open = not self.open
            self.write("opens" if self.open else "closes")
        return self.exit_out if self.enter and self.open else None


class Post(Node, type="test.Post"):
    """Posts a number to a mailbox, so many times."""

    exec_in = ExecIn()
    name: str = In(default="messages", setup=True)
    value: float = In(default=0.0)
    times: int = In(default=1)
    exec_out = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        self.mailbox = context.mailbox(self.name)

    def compute(self) -> None:
        for _ in range(self.times):
            self.mailbox.post(self.value)


class WriteVariable(Journaling, type="test.WriteVariable"):
    """Sets a variable of the graph."""

    exec_in = ExecIn()
    variable_name: str = In(default="speed", setup=True)
    value: float = In(default=0.0)
    exec_out = ExecOut()

    variable: Variable = Bound()

    def setup(self, context: Context) -> None:
        super().setup(context)
        self.variable = context.variable(self.variable_name)

    def compute(self) -> None:
        self.variable.value = self.value
        self.write(self.value)

    def writes(self) -> Iterable[str]:
        return (f"variable:{self.variable_name}",)


class Raise(Node, type="test.Raise"):
    """Raises at a pass, and leaves an output half written."""

    exec_in = ExecIn()
    at: float = In(default=1.0)
    label: str = In(default="")
    exec_out = ExecOut()
    count: float = Out()

    def compute(self) -> None:
        self.count += 1.0
        if self.count == self.at:
            raise ZeroDivisionError("it was to be expected")


class Announce(Journaling, type="test.Announce"):
    """Opens a topic in setup, and again whenever its name changes."""

    exec_in = ExecIn()
    topic: String = In(default="", setup=True)
    qualifier: String = In(default="", setup=True)
    forbidden: String = In(default="forbidden")
    exec_out = ExecOut()
    opened: String = Out()

    def setup(self, context: Context) -> None:
        super().setup(context)
        if self.topic == self.forbidden:
            raise ValueError("this topic is forbidden")
        self.opened = f"/{self.topic}{self.qualifier}"
        self.write("opens", self.opened)

    def compute(self) -> None:
        self.write("sends on", self.opened)


class Spell(Node, type="test.Spell"):
    """Turns the number of its computes into a text."""

    exec_in = ExecIn()
    step: int = In(default=1)
    exec_out = ExecOut()
    text: String = Out()

    computes: int = State(default=0)

    def compute(self) -> None:
        self.computes += self.step
        self.text = f"t{self.computes}"


class Dice(Journaling, type="test.Dice"):
    """Writes down a random number."""

    exec_in = ExecIn()
    random: Any = Bound()

    def setup(self, context: Context) -> None:
        super().setup(context)
        self.random = context.random()

    def compute(self) -> None:
        self.write(int(self.random.integers(1_000_000)))
