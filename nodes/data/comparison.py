"""Nodes that compare values with each other or with 0 (`omni.graph.nodes`)."""

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
    """Compares two values with an operator such as `<`.

    Arrays are compared element by element, tuples and strings lexicographically.
    """

    a: Any = In(type=_COMPARED, required=True, doc="left operand")
    b: Any = In(type=_COMPARED, required=True, doc="right operand")
    operation: Token = In(default=">", tokens=tuple(_OPERATIONS))
    result: Any = Out(type=BOOLEANS, doc="result of the comparison; array of bools if `a` or `b` is an array")

    operands: Any = Bound()

    def setup(self, context: Context) -> None:
        """Select the comparison of whole values or of array elements, according to the resolved port types."""
        known = self.port_types()
        self.operands = _as_they_are if not known["result"].array else _pairs(known["a"], known["b"])

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type bool, or bool[] if an operand is an array.

        Raises:
            ValueError: only one operand is numeric, or the operands have different numbers of components.
        """
        a, b = given["a"], given["b"]
        if a.is_number != b.is_number or a.count != b.count:
            raise ValueError(f"a is {a} and b is {b}, which cannot be compared")
        return PortType("bool", 1, a.array or b.array)

    def compute(self) -> None:
        """Set `result` to the result of the comparison.

        Raises:
            BadValueError: `operation` is not a known operator, or two arrays differ in length.
        """
        operation = _OPERATIONS[one_of("operation", self.operation, _OPERATIONS)]
        self.result = self.operands(operation, self.a, self.b)


def _as_they_are(operation: Operation, a: Any, b: Any) -> bool:
    found: bool = operation(a, b)  # Python's order of tuples and texts is the one that is meant
    return found


def _pairs(a: PortType, b: PortType) -> Operation:
    """Return the element-wise comparison for operands of which at least one is an array."""

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
    """Base class of nodes that compare numbers with 0 within a tolerance."""

    tolerance: float = In(default=0.0, ge=0.0, doc="largest absolute value that counts as 0")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array to compare with 0")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type bool for all input types."""
        return PortType("bool")


class IsZero(_Zero, type="omni.graph.nodes.IsZero"):
    """Checks whether all numbers of a value are 0."""

    result: bool = Out(doc="whether all numbers of `value` are 0")

    @staticmethod
    def operation(tolerance: Any, value: Any) -> Any:
        """Return whether all numbers of an array are 0 within the tolerance."""
        return np.all(np.abs(value) <= tolerance)

    @staticmethod
    def on_numbers(tolerance: float, value: float) -> bool:
        """Return whether one number is 0 within the tolerance."""
        return abs(value) <= tolerance


class AnyZero(_Zero, type="omni.graph.nodes.AnyZero"):
    """Checks whether at least one number in a value is 0; for an array of tuples, whether one tuple consists only of zeros."""

    result: bool = Out(doc="whether any number is 0; for an array of tuples, whether any tuple consists only of zeros")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that takes the port values and checks whether any number or tuple is 0."""
        zeros = _zeros(inputs[1])
        return lift(lambda tolerance, value: np.any(zeros(tolerance, value)), inputs, output)


class EachZero(_Zero, type="omni.graph.nodes.EachZero"):
    """Checks for each number of a value whether it is 0; for an array of tuples, whether each tuple consists only of zeros."""

    result: Any = Out(type=BOOLEANS, doc="bool for a number; array of bools, one per element, for a tuple or an array")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that takes the port values and checks for each number or tuple whether it is 0."""
        return lift(_zeros(inputs[1]), inputs, output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type bool for a number, and bool[] for a tuple or an array."""
        value = given["value"]
        return PortType("bool", 1, value.array or value.count > 1)


def _zeros(port_type: PortType) -> Operation:
    """Return a function that compares each number with 0; in an array of tuples, it compares each tuple as a whole."""
    if port_type.array and port_type.count > 1:
        return lambda tolerance, value: np.all(np.abs(value) <= tolerance, axis=-1)
    return lambda tolerance, value: np.abs(value) <= tolerance
