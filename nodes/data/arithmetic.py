"""Arithmetic on numbers, tuples and arrays (`omni.graph.nodes`); `broadcast` defines how their types combine."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graphengine.node import BadValueError, In, Out, PortType
from graphengine.nodes.data.broadcast import Operation, is_real, lift
from graphengine.nodes.data.elementwise import Elementwise, Folded
from graphengine.nodes.data.unions import INTEGRAL_SCALARS, NUMERICS


class Add(Folded, type="omni.graph.nodes.Add"):
    """Sum of two or more values."""

    operation = on_numbers = operator.add

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(
        type=NUMERICS, required=True, doc="added to `a`; a graph file can name further inputs `input2`, `input3`, …"
    )
    sum: Any = Out(type=NUMERICS, doc="sum of all inputs")


class Subtract(Folded, type="omni.graph.nodes.Subtract"):
    """Difference of a value and one or more others."""

    operation = on_numbers = operator.sub

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(
        type=NUMERICS,
        required=True,
        doc="subtracted from `a`; a graph file can name further inputs `input2`, `input3`, …",
    )
    difference: Any = Out(type=NUMERICS, doc="`a` minus all other inputs")


class Multiply(Folded, type="omni.graph.nodes.Multiply"):
    """Product of two or more values, number by number; MatrixMultiply computes the matrix product."""

    operation = on_numbers = operator.mul

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(
        type=NUMERICS, required=True, doc="second factor; a graph file can name further inputs `input2`, `input3`, …"
    )
    product: Any = Out(type=NUMERICS, doc="product of all inputs")


class Divide(Elementwise, type="omni.graph.nodes.Divide"):
    """Quotient of a value and a scalar; the quotient of integers is a double."""

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="number, or array of numbers if `a` is an array; 0 is an error")
    result: Any = Out(type=NUMERICS, doc="`a` / `b`, of the type of `a`; doubles if `a` consists of integers")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Divide arrays.

        Raises:
            BadValueError: a number in `b` is 0.
        """
        if not np.all(b):
            raise BadValueError("b", b, "other than 0")
        return a / b

    @staticmethod
    def on_numbers(a: Any, b: Any) -> Any:
        """Divide two numbers.

        Raises:
            BadValueError: `b` is 0.
        """
        if not b:
            raise BadValueError("b", b, "other than 0")
        return a / b

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of `a`, with doubles in place of integers.

        Raises:
            ValueError: `b` is neither a scalar nor an array with one number per element of `a`.
        """
        a, b = given["a"], given["b"]
        if b.count > 1 or (b.array and not a.array):
            raise ValueError(f"a is {a} and b is {b}; b must be one number, or an array of numbers if a is an array")
        return a if is_real(a) else PortType("double", a.count, a.array)


class Modulo(Elementwise, type="omni.graph.nodes.Modulo"):
    """Remainder of an integer division that truncates toward 0, so it has the sign of `a`; 0 if `b` is 0."""

    a: Any = In(type=INTEGRAL_SCALARS, required=True, doc="dividend")
    b: Any = In(type=INTEGRAL_SCALARS, required=True, doc="divisor")
    result: Any = Out(type=INTEGRAL_SCALARS, doc="`a` - `b` * trunc(`a` / `b`); 0 if `b` is 0")

    @staticmethod
    def operation(a: int, b: int) -> int:
        """Compute the remainder of two integers."""
        if b == 0:
            return 0
        return abs(a) % abs(b) if a >= 0 else -(abs(a) % abs(b))

    on_numbers = operation


class Negate(Elementwise, type="omni.graph.nodes.Negate"):
    """A value with its sign inverted."""

    operation = on_numbers = operator.neg

    input_in: Any = In(type=NUMERICS, name="input", required=True, doc="number, tuple or array")
    output: Any = Out(type=NUMERICS, doc="`input` times -1")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the input.

        Raises:
            ValueError: the type is unsigned.
        """
        if given["input"].base in ("uchar", "uint", "uint64"):
            raise ValueError(f"input is {given['input']}, which has no negative numbers")
        return given["input"]


def _incremented(value: int, increment: float) -> float:
    """The sum. Two integers are added exactly: Unix times in nanoseconds need 61 bits, and a double has only 53."""
    return value + (int(increment) if increment.is_integer() else increment)


class Increment(Elementwise, type="omni.graph.nodes.Increment"):
    """Sum of a value and a number, of the value's type: the integer 4 plus 3.2 is 7."""

    like = "value"

    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    increment: float = In(default=1.0, doc="number to add to each number of `value`")
    result: Any = Out(type=NUMERICS, doc="sum, of the type of `value`; truncated toward 0 if that is an integer type")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the addition, which truncates toward 0 if the output is an integer."""
        if is_real(output):
            return lift(operator.add, inputs, output, operator.add)
        return lift(lambda value, increment: np.trunc(value + increment), inputs, output, _incremented)
