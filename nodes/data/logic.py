"""True and false joined (`omni.graph.nodes`), one by one or element by element of arrays."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, ClassVar

from graphengine.node import In, Node, Numbered, Out, PortType, Token
from graphengine.nodes.checked import one_of
from graphengine.nodes.data.broadcast import Operation
from graphengine.nodes.data.elementwise import Elementwise, Folded
from graphengine.nodes.data.unions import BOOLEANS


class _Gate(Folded):
    """Two or more truth values joined into one."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=BOOLEANS, required=True)}

    a: Any = In(type=BOOLEANS, required=True, doc="bool, or an array")
    b: Any = In(type=BOOLEANS, required=True, doc="bool, or an array as long; input2 and so on are there when named")
    result: Any = Out(type=BOOLEANS, doc="an array where one of the inputs is one")


class _InvertedGate(_Gate):
    """The contrary of two or more truth values joined into one."""

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """The contrary of the operation."""
        joined = super().lifted(inputs, output)
        return lambda *values: True ^ joined(*values)


class BooleanAnd(_Gate, type="omni.graph.nodes.BooleanAnd"):
    """Whether all inputs are true."""

    operation = on_numbers = operator.and_


class BooleanOr(_Gate, type="omni.graph.nodes.BooleanOr"):
    """Whether one of the inputs is true, or more."""

    operation = on_numbers = operator.or_


class BooleanNand(_InvertedGate, type="omni.graph.nodes.BooleanNand"):
    """Whether one of the inputs is false, or more."""

    operation = on_numbers = operator.and_


class BooleanNor(_InvertedGate, type="omni.graph.nodes.BooleanNor"):
    """Whether all inputs are false."""

    operation = on_numbers = operator.or_


class BooleanNot(Elementwise, type="omni.graph.nodes.BooleanNot"):
    """The contrary of a truth value."""

    value_in: Any = In(type=BOOLEANS, required=True)
    value_out: Any = Out(type=BOOLEANS)

    @staticmethod
    def operation(value: Any) -> Any:
        """The contrary of arrays, and of single values."""
        return True ^ value

    on_numbers = operation


class BooleanExpr(Node, type="omni.graph.nodes.BooleanExpr"):
    """Two truth values joined as a word says: AND, OR, NAND, NOR, XOR or XNOR."""

    a: bool = In(default=False, doc="one of them")
    b: bool = In(default=False, doc="the other")
    operator_in: Token = In(default="AND", name="operator", doc="AND, OR, NAND, NOR, XOR or XNOR")
    result: bool = Out(doc="what they make")

    def compute(self) -> None:
        """Join.

        Raises:
            BadValueError: the operator is none of these.
        """
        joined = {"AND": self.a and self.b, "OR": self.a or self.b, "XOR": self.a != self.b, "XNOR": self.a == self.b}
        joined |= {"NAND": not joined["AND"], "NOR": not joined["OR"]}
        self.result = joined[one_of("operator", self.operator_in, joined)]
