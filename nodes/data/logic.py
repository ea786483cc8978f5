"""Boolean operations (`omni.graph.nodes`) on scalars, and on arrays element by element."""

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
    """Base of operations on two or more booleans."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=BOOLEANS, required=True)}

    a: Any = In(type=BOOLEANS, required=True, doc="bool, or array of bools")
    b: Any = In(
        type=BOOLEANS,
        required=True,
        doc="bool, or array as long as `a`; a graph file can name further inputs `input2`, `input3`, …",
    )
    result: Any = Out(type=BOOLEANS, doc="bool, or array of bools if an input is an array")


class _InvertedGate(_Gate):
    """Base of operations on two or more booleans with a negated result."""

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the negated operation."""
        joined = super().lifted(inputs, output)
        return lambda *values: True ^ joined(*values)


class BooleanAnd(_Gate, type="omni.graph.nodes.BooleanAnd"):
    """Whether all inputs are true."""

    operation = on_numbers = operator.and_


class BooleanOr(_Gate, type="omni.graph.nodes.BooleanOr"):
    """Whether at least one input is true."""

    operation = on_numbers = operator.or_


class BooleanNand(_InvertedGate, type="omni.graph.nodes.BooleanNand"):
    """Whether at least one input is false."""

    operation = on_numbers = operator.and_


class BooleanNor(_InvertedGate, type="omni.graph.nodes.BooleanNor"):
    """Whether all inputs are false."""

    operation = on_numbers = operator.or_


class BooleanNot(Elementwise, type="omni.graph.nodes.BooleanNot"):
    """Negation of a boolean."""

    value_in: Any = In(type=BOOLEANS, required=True)
    value_out: Any = Out(type=BOOLEANS)

    @staticmethod
    def operation(value: Any) -> Any:
        """Negate arrays and scalars."""
        return True ^ value

    on_numbers = operation


class BooleanExpr(Node, type="omni.graph.nodes.BooleanExpr"):
    """Combines two booleans by the operator that an input names."""

    a: bool = In(default=False, doc="first operand")
    b: bool = In(default=False, doc="second operand")
    operator_in: Token = In(default="AND", name="operator", doc="AND, OR, NAND, NOR, XOR or XNOR")
    result: bool = Out(doc="result of the operation")

    def compute(self) -> None:
        """Apply the operator.

        Raises:
            BadValueError: the operator is unknown.
        """
        joined = {"AND": self.a and self.b, "OR": self.a or self.b, "XOR": self.a != self.b, "XNOR": self.a == self.b}
        joined |= {"NAND": not joined["AND"], "NOR": not joined["OR"]}
        self.result = joined[one_of("operator", self.operator_in, joined)]
