"""Nodes that combine booleans (`omni.graph.nodes`); arrays are combined element by element."""

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
    """Base class of logic gates with two or more boolean inputs."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=BOOLEANS, required=True)}

    a: Any = In(type=BOOLEANS, required=True, doc="first operand: bool, or array of bools")
    b: Any = In(type=BOOLEANS, required=True, doc="second operand, like `a`; a graph can add `input2`, `input3`, …")
    result: Any = Out(type=BOOLEANS, doc="bool, or array of bools if an input is an array")


class _InvertedGate(_Gate):
    """Base class of logic gates with a negated result: NAND and NOR."""

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the operation with a negated result."""
        joined = super().lifted(inputs, output)
        return lambda *values: True ^ joined(*values)


class BooleanAnd(_Gate, type="omni.graph.nodes.BooleanAnd"):
    """Checks whether all inputs are true."""

    operation = on_numbers = operator.and_


class BooleanOr(_Gate, type="omni.graph.nodes.BooleanOr"):
    """Checks whether at least one input is true."""

    operation = on_numbers = operator.or_


class BooleanNand(_InvertedGate, type="omni.graph.nodes.BooleanNand"):
    """Checks whether at least one input is false."""

    operation = on_numbers = operator.and_


class BooleanNor(_InvertedGate, type="omni.graph.nodes.BooleanNor"):
    """Checks whether all inputs are false."""

    operation = on_numbers = operator.or_


class BooleanNot(Elementwise, type="omni.graph.nodes.BooleanNot"):
    """Negates a boolean, or each boolean of an array."""

    value_in: Any = In(type=BOOLEANS, required=True)
    value_out: Any = Out(type=BOOLEANS)

    @staticmethod
    def operation(value: Any) -> Any:
        """Return the negation of a boolean or of an array of booleans."""
        return True ^ value

    on_numbers = operation


class BooleanExpr(Node, type="omni.graph.nodes.BooleanExpr"):
    """Combines two booleans with the logical operator that the input `operator` names."""

    a: bool = In(default=False, doc="first operand")
    b: bool = In(default=False, doc="second operand")
    operator_in: Token = In(default="AND", name="operator", doc="name of the operator: AND, OR, NAND, NOR, XOR or XNOR")
    result: bool = Out(doc="result of the operation")

    def compute(self) -> None:
        """Set `result` to `a` and `b` combined with the operator.

        Raises:
            BadValueError: `operator` is not a known operator.
        """
        joined = {"AND": self.a and self.b, "OR": self.a or self.b, "XOR": self.a != self.b, "XNOR": self.a == self.b}
        joined |= {"NAND": not joined["AND"], "NOR": not joined["OR"]}
        self.result = joined[one_of("operator", self.operator_in, joined)]
