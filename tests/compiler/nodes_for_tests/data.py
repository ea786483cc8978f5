"""Data nodes, which are computed for who reads them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from graphengine.messages.definitions import Definitions
from graphengine.node import Bound, Context, Double, In, Int64, Node, Out, State, String, Token, Variable, node


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

    variable: Variable = Bound()
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
