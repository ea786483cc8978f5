"""Sums, products and what is near to them (`omni.graph.nodes`); of numbers, tuples and arrays as `broadcast` says."""

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
    b: Any = In(type=NUMERICS, required=True, doc="is added to a; input2 and so on are there when a file names them")
    sum: Any = Out(type=NUMERICS, doc="a + b")


class Subtract(Folded, type="omni.graph.nodes.Subtract"):
    """What is left of a value when one or more others are taken from it."""

    operation = on_numbers = operator.sub

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="is taken from a; input2 and so on are there when a file names them")
    difference: Any = Out(type=NUMERICS, doc="a - b")


class Multiply(Folded, type="omni.graph.nodes.Multiply"):
    """Product of two or more values, number by number; that of matrices is MatrixMultiply."""

    operation = on_numbers = operator.mul

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="a factor; input2 and so on are there when a file names them")
    product: Any = Out(type=NUMERICS, doc="a * b")


class Divide(Elementwise, type="omni.graph.nodes.Divide"):
    """Quotient of a value by a single number; of whole numbers too it is a double."""

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="a number, or an array of numbers where a is an array; 0 is an error")
    result: Any = Out(type=NUMERICS, doc="a / b, of the type of a unless that is whole")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Divide arrays.

        Raises:
            BadValueError: by 0.
        """
        if not np.all(b):
            raise BadValueError("b", b, "other than 0")
        return a / b

    @staticmethod
    def on_numbers(a: Any, b: Any) -> Any:
        """Divide two numbers.

        Raises:
            BadValueError: by 0.
        """
        if not b:
            raise BadValueError("b", b, "other than 0")
        return a / b

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """That of a, or of doubles.

        Raises:
            ValueError: a is divided by more than a number.
        """
        a, b = given["a"], given["b"]
        if b.count > 1 or (b.array and not a.array):
            raise ValueError(f"a is {a} and b is {b}; b is one number, or as many as a is long")
        return a if is_real(a) else PortType("double", a.count, a.array)


class Modulo(Elementwise, type="omni.graph.nodes.Modulo"):
    """Remainder of a division of whole numbers that is cut off toward 0, so it has the sign of a; 0 if b is 0."""

    a: Any = In(type=INTEGRAL_SCALARS, required=True, doc="is divided")
    b: Any = In(type=INTEGRAL_SCALARS, required=True, doc="divides")
    result: Any = Out(type=INTEGRAL_SCALARS, doc="a - b * trunc(a / b)")

    @staticmethod
    def operation(a: int, b: int) -> int:
        """Remainder of Python numbers."""
        if b == 0:
            return 0
        return abs(a) % abs(b) if a >= 0 else -(abs(a) % abs(b))

    on_numbers = operation


class Negate(Elementwise, type="omni.graph.nodes.Negate"):
    """A value with the other sign."""

    operation = on_numbers = operator.neg

    input_in: Any = In(type=NUMERICS, name="input", required=True, doc="number, tuple or array")
    output: Any = Out(type=NUMERICS, doc="the input times -1")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """That of the input.

        Raises:
            ValueError: it has no negative numbers.
        """
        if given["input"].base in ("uchar", "uint", "uint64"):
            raise ValueError(f"input is {given['input']}, which has no negative numbers")
        return given["input"]


def _incremented(value: int, increment: float) -> float:
    """Their sum, exact where both are whole: a double has 53 bits, and nanoseconds of today's time have 61."""
    return value + (int(increment) if increment.is_integer() else increment)


class Increment(Elementwise, type="omni.graph.nodes.Increment"):
    """A value with a number added to it, of the value's type: 4 and 3.2 make 7 where the value is whole."""

    like = "value"

    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    increment: float = In(default=1.0, doc="is added to each of them")
    result: Any = Out(type=NUMERICS, doc="the sum, cut off toward 0 where it is whole")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """A sum, which is cut off where it is to be whole."""
        if is_real(output):
            return lift(operator.add, inputs, output, operator.add)
        return lift(lambda value, increment: np.trunc(value + increment), inputs, output, _incremented)
