"""Small nodes, one for each shape and rule; what they do they write to a journal, in the order they do it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.context import Clock, Context, Mailbox, Publisher, Variable
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, Pushes, State, node
from graphengine.ros.definitions import Definitions
from graphengine.types import Double, Int64, String, Token


class Journaling(Node):
    """Base of nodes that write down what they do."""

    journal: Publisher = State()
    me: str = State()

    def setup(self, context: Context) -> None:
        self.journal = context.publisher("std_msgs/msg/String", "journal")
        self.me = context.prim_path.rpartition("/")[2]

    def write(self, *words: object) -> None:
        self.journal.publish(" ".join([self.me, *(f"{w:g}" if isinstance(w, float) else str(w) for w in words)]))


# Events


class Tick(Node, type="test.Tick"):
    """Fires every pass."""

    tick = ExecOut()
    number: float = Out()
    time: float = Out()

    clock: Clock = State()

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

    mailbox: Mailbox = State()

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

    mailbox: Mailbox = State()

    def setup(self, context: Context) -> None:
        self.mailbox = context.mailbox(self.name)

    def compute(self) -> Pushes:
        for item in self.mailbox.take():
            self.value = item
            yield self.received
        yield self.done


# Actions


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

    mailbox: Mailbox = State()

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

    variable: Variable = State()

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
    exec_out = ExecOut()
    text: String = Out()

    computes: int = State(default=0)

    def compute(self) -> None:
        self.computes += 1
        self.text = f"t{self.computes}"


class Dice(Journaling, type="test.Dice"):
    """Writes down a random number."""

    exec_in = ExecIn()
    random: Any = State()

    def setup(self, context: Context) -> None:
        super().setup(context)
        self.random = context.random()

    def compute(self) -> None:
        self.write(int(self.random.integers(1_000_000)))


# Pushers


class Sequence(Node, type="test.Sequence"):
    """Fires its ports one after the other."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    c = ExecOut()

    def compute(self) -> Pushes:
        yield self.a
        yield self.b
        yield self.c


class Both(Node, type="test.Both"):
    """Fires two ports in one yield."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    index: float = Out()

    def compute(self) -> Pushes:
        for i in range(2):
            self.index = float(i)
            yield self.a | self.b


class ForLoop(Journaling, type="test.ForLoop"):
    """Fires for each number below `stop`, until it is told to break."""

    exec_in = ExecIn()
    break_loop = ExecIn(control=True)
    stop: int = In(default=3)
    loop_body = ExecOut()
    finished = ExecOut()
    index: float = Out()

    def compute(self) -> Pushes:
        for i in range(self.stop):
            self.index = float(i)
            yield self.loop_body
            if self.break_loop:
                self.write("breaks")
                break
        yield self.finished


class WhileLoop(Node, type="test.WhileLoop"):
    """Fires while a condition holds that is read before each round, but four times at most."""

    rereads = True

    exec_in = ExecIn()
    condition: bool = In(default=False)
    loop_body = ExecOut()
    index: float = Out()
    finished = ExecOut()

    def compute(self) -> Pushes:
        self.index = 0.0
        while self.condition and self.index < 4.0:
            yield self.loop_body
            self.index += 1.0
        yield self.finished


# Latent


class Delay(Journaling, type="test.Delay"):
    """Fires when so much simulation time has passed since it was last started."""

    exec_in = ExecIn()
    duration: float = In(default=0.05)
    finished = ExecOut()
    started: float = Out()
    updates: float = Out()

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        super().setup(context)
        self.clock = context.clock

    def compute(self) -> None:
        self.started = self.clock.time
        self.active = True

    def update(self) -> Fire:
        self.updates += 1.0
        if self.clock.time - self.started < self.duration - 1e-9:
            return None
        self.active = False
        self.write("ends")
        return self.finished


class Stages(Node, type="test.Stages"):
    """In its n-th update it fires the ports that the n-th digit of `plan` has bits for."""

    exec_in = ExecIn()
    plan: String = In(default="123")
    first = ExecOut()
    second = ExecOut()

    updates: int = State(default=0)

    def compute(self) -> None:
        self.active = True
        self.updates = 0

    def update(self) -> Fire:
        bits = int(self.plan[self.updates])
        self.updates += 1
        self.active = self.updates < len(self.plan)
        return bits


class FailsLater(Node, type="test.FailsLater"):
    """Raises in its second update."""

    exec_in = ExecIn()
    updates: float = Out()

    def compute(self) -> None:
        self.active = True

    def update(self) -> Fire:
        self.updates += 1.0
        if self.updates == 2.0:
            raise RuntimeError("tired")
        return None


# Data


class Word(Node, type="test.Word"):
    """A word by a number."""

    number: float = In(default=0.0)
    word: Token = Out()

    def compute(self) -> None:
        self.word = "a" if self.number % 2 else "b"


class Add(Node, type="test.Add"):
    """Sum of two numbers; counts how often it was computed."""

    a: float = In(default=0.0)
    b: float = In(default=0.0)
    sum: float = Out()

    computes: int = State(default=0)

    def compute(self) -> None:
        self.computes += 1
        self.sum = self.a + self.b


class Constant(Node, type="test.Constant"):
    """A number; wires begin at its input."""

    value: float = In(default=0.0)


class Whole(Node, type="test.Whole"):
    """A whole number."""

    value: int = In(default=0)
    out: Int64 = Out()

    def compute(self) -> None:
        self.out = self.value


class Text(Node, type="test.Text"):
    """Two texts put together; may refuse an empty one."""

    a: String = In(default="")
    b: String = In(default="")
    strict: bool = In(default=False)
    text: String = Out()

    computes: int = State(default=0)

    def compute(self) -> None:
        self.computes += 1
        if self.strict and not self.a:
            raise ValueError("empty text")
        self.text = self.a + self.b


class Less(Node, type="test.Less"):
    """Whether one number is below another."""

    a: float = In(default=0.0)
    b: float = In(default=0.0)
    result: bool = Out()

    def compute(self) -> None:
        self.result = self.a < self.b


class Reciprocal(Node, type="test.Reciprocal"):
    """One over a number; raises at zero."""

    value: float = In(default=1.0)
    result: float = Out()

    def compute(self) -> None:
        self.result = 1.0 / self.value


class Ticket(Node, type="test.Ticket", volatile=True):
    """A number from outside, another one each time it is read."""

    number: float = Out()

    def compute(self) -> None:
        self.number += 1.0


class ReadVariable(Node, type="test.ReadVariable", volatile=True):
    """A variable of the graph."""

    variable_name: str = In(default="speed", setup=True)
    value: Double = Out()

    variable: Variable = State()
    computes: int = State(default=0)

    def setup(self, context: Context) -> None:
        self.variable = context.variable(self.variable_name)

    def compute(self) -> None:
        self.computes += 1
        self.value = self.variable.value

    def reads(self) -> Iterable[str]:
        return (f"variable:{self.variable_name}",)


@node("test.Double")
def Twice(number: float) -> float:
    """Twice a number."""
    return 2.0 * number


class Sums(Node, type="test.Sums"):
    """Sum of as many inputs as `count` says."""

    count: int = In(default=2)
    sum: float = Out()

    def compute(self) -> None:
        self.sum = sum(getattr(self, f"input{i}") for i in range(self.count))

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        count = literals.get("count", 2)
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"count must be a positive whole number, got {count!r}")
        return {f"input{i}": In(type="double", default=float(literals.get("first", 0.0))) for i in range(count)}
