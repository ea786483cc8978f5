"""Values compared with each other and with 0 (`omni.graph.nodes`)."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graphengine.node import Bound, Context, In, Out, PortType, Token
from graphengine.nodes.checked import one_of, same_length
from graphengine.nodes.data.broadcast import Operand, Operation, lift
from graphengine.nodes.data.elementwise import Elementwise, TypedNode
from graphengine.nodes.data.unions import BOOLEANS, NUMERICS

_OPERATIONS: dict[str, Operation] = {
    ">": operator.gt,
    "<": operator.lt,
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}
_COMPARED = f"bool|{NUMERICS}|bool[]|token|string|path|token[]"


class Compare(TypedNode, type="omni.graph.nodes.Compare"):
    """Whether one value is above, below or equal to another; of arrays, element by element.

    Tuples are compared by their first components that differ, and texts by their letters.
    """

    a: Any = In(type=_COMPARED, required=True, doc="stands left of the operation")
    b: Any = In(type=_COMPARED, required=True, doc="stands right of it")
    operation: Token = In(default=">", tokens=tuple(_OPERATIONS))
    result: Any = Out(type=BOOLEANS, doc="an array where a or b is one")

    operands: Any = Bound()

    def setup(self, context: Context) -> None:
        """Choose how to bring the operands together."""
        known = self.port_types()
        self.operands = _as_they_are if not known["result"].array else _pairs(known["a"], known["b"])

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """One answer, or an array of them.

        Raises:
            ValueError: what is to be compared is not of one kind, or not as long.
        """
        a, b = given["a"], given["b"]
        if a.is_number != b.is_number or a.count != b.count:
            raise ValueError(f"a is {a} and b is {b}, which do not compare")
        return PortType("bool", 1, a.array or b.array)

    def compute(self) -> None:
        """Compare.

        Raises:
            BadValueError: there is no such operation, or arrays differ in length.
        """
        operation = _OPERATIONS[one_of("operation", self.operation, _OPERATIONS)]
        self.result = self.operands(operation, self.a, self.b)


def _as_they_are(operation: Operation, a: Any, b: Any) -> bool:
    found: bool = operation(a, b)  # Python's order of tuples and texts is the one that is meant
    return found


def _pairs(a: PortType, b: PortType) -> Operation:
    """How elements are compared where one or both operands are arrays."""

    def columns(operation: Operation, one: Any, other: Any) -> Any:
        operands = [Operand.of(a, "a"), Operand.of(b, "b")]
        return lift(operation, operands, PortType("bool", 1, True))(one, other)

    def rows(operation: Operation, one: Any, other: Any) -> Any:
        ones, others = _elements(one, a), _elements(other, b)
        length = max(len(ones) if a.array else 0, len(others) if b.array else 0)
        ones, others = ones if a.array else ones * length, others if b.array else others * length
        same_length(a=ones, b=others)
        return np.array([operation(x, y) for x, y in zip(ones, others, strict=True)], np.bool_)

    return columns if a.is_number and a.count == 1 else rows


def _elements(value: Any, port_type: PortType) -> list[Any]:
    if not port_type.array:
        return [value]
    return list(map(tuple, value.tolist())) if port_type.is_number else list(value)


class _Zero(Elementwise):
    """Which numbers are so near to 0 that they count as 0."""

    tolerance: float = In(default=0.0, doc="numbers up to this far from 0 are taken for 0")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """One answer."""
        return PortType("bool")


class IsZero(_Zero, type="omni.graph.nodes.IsZero"):
    """Whether all numbers of a value are 0."""

    result: bool = Out(doc="true where the value has no other number")

    @staticmethod
    def operation(tolerance: Any, value: Any) -> Any:
        """Of arrays."""
        return np.all(np.abs(value) <= tolerance)

    @staticmethod
    def on_numbers(tolerance: float, value: float) -> bool:
        """Of one number."""
        return abs(value) <= tolerance


class AnyZero(_Zero, type="omni.graph.nodes.AnyZero"):
    """Whether a number of a value is 0; of an array of tuples, whether all numbers of one of them are."""

    result: bool = Out(doc="true where there is one")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """With tuples of an array as wholes."""
        wholes = inputs[1].array and inputs[1].count > 1
        return lift(lambda tolerance, value: np.any(_zeros(tolerance, value, wholes)), inputs, output)


class EachZero(_Zero, type="omni.graph.nodes.EachZero"):
    """Which numbers of a value are 0; of an array of tuples, which of them are 0 in all their numbers."""

    result: Any = Out(type=BOOLEANS, doc="an answer for a number, an array of them for a tuple or an array")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """With tuples of an array as wholes."""
        wholes = inputs[1].array and inputs[1].count > 1
        return lift(lambda tolerance, value: _zeros(tolerance, value, wholes), inputs, output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """One answer for a number, else an array of them."""
        value = given["value"]
        return PortType("bool", 1, value.array or value.count > 1)


def _zeros(tolerance: Any, value: Any, wholes: bool) -> Any:
    near = np.abs(value) <= tolerance
    return np.all(near, axis=-1) if wholes else near
