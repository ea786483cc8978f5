"""Nodes that do arithmetic on numbers, tuples and arrays (`omni.graph.nodes`).

The module `broadcast` determines the types of their results.
"""

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
    """Adds two or more values."""

    operation = on_numbers = operator.add

    a: Any = In(type=NUMERICS, required=True, doc="first summand: number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="second summand; a graph can add `input2`, `input3`, …")
    sum: Any = Out(type=NUMERICS, doc="sum of all inputs")


class Subtract(Folded, type="omni.graph.nodes.Subtract"):
    """Subtracts one or more values from `a`."""

    operation = on_numbers = operator.sub

    a: Any = In(type=NUMERICS, required=True, doc="number, tuple or array to subtract from")
    b: Any = In(type=NUMERICS, required=True, doc="value to subtract from `a`; a graph can add `input2`, `input3`, …")
    difference: Any = Out(type=NUMERICS, doc="`a` minus all other inputs")


class Multiply(Folded, type="omni.graph.nodes.Multiply"):
    """Multiplies two or more values, component by component; MatrixMultiply computes the matrix product."""

    operation = on_numbers = operator.mul

    a: Any = In(type=NUMERICS, required=True, doc="first factor: number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="second factor; a graph can add `input2`, `input3`, …")
    product: Any = Out(type=NUMERICS, doc="product of all inputs")


class Divide(Elementwise, type="omni.graph.nodes.Divide"):
    """Divides a value by a number, or an array by an array of numbers; quotients of integers are doubles."""

    a: Any = In(type=NUMERICS, required=True, doc="dividend: number, tuple or array")
    b: Any = In(type=NUMERICS, required=True, doc="divisor: number, or array if `a` is an array; 0 is an error")
    result: Any = Out(type=NUMERICS, doc="`a` / `b`; has the type of `a`, with doubles in place of integers")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Return the quotients of two arrays.

        Raises:
            BadValueError: `b` contains a 0.
        """
        if not np.all(b):
            raise BadValueError("b", b, "other than 0")
        return a / b

    @staticmethod
    def on_numbers(a: Any, b: Any) -> Any:
        """Return the quotient of two numbers.

        Raises:
            BadValueError: `b` is 0.
        """
        if not b:
            raise BadValueError("b", b, "other than 0")
        return a / b

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of `a`, with doubles in place of integers.

        Raises:
            ValueError: `b` consists of tuples, or `b` is an array but `a` is not.
        """
        a, b = given["a"], given["b"]
        if b.count > 1 or (b.array and not a.array):
            raise ValueError(f"a is {a} and b is {b}; b must be one number, or an array of numbers if a is an array")
        return a if is_real(a) else PortType("double", a.count, a.array)


class Modulo(Elementwise, type="omni.graph.nodes.Modulo"):
    """Computes the remainder of an integer division. The remainder has the sign of `a`, and is 0 if `b` is 0."""

    a: Any = In(type=INTEGRAL_SCALARS, required=True, doc="dividend, an integer")
    b: Any = In(type=INTEGRAL_SCALARS, required=True, doc="divisor, an integer")
    result: Any = Out(type=INTEGRAL_SCALARS, doc="`a` - `b` * trunc(`a` / `b`); 0 if `b` is 0")

    @staticmethod
    def operation(a: int, b: int) -> int:
        """Return the remainder with the sign of `a`; 0 if `b` is 0."""
        if b == 0:
            return 0
        return abs(a) % abs(b) if a >= 0 else -(abs(a) % abs(b))

    on_numbers = operation


class Negate(Elementwise, type="omni.graph.nodes.Negate"):
    """Inverts the sign of a value."""

    operation = on_numbers = operator.neg

    input_in: Any = In(type=NUMERICS, name="input", required=True, doc="number, tuple or array to negate")
    output: Any = Out(type=NUMERICS, doc="`input` times -1")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the input, which is also the type of the output.

        Raises:
            ValueError: the input type is unsigned.
        """
        if given["input"].base in ("uchar", "uint", "uint64"):
            raise ValueError(f"input is {given['input']}, which has no negative numbers")
        return given["input"]


def _incremented(value: int, increment: float) -> float:
    """Return the sum of a value and an increment.

    Whole increments are added to integers exactly, without doubles: Unix times in ns need 61 bits, but a double has only 53.
    """
    return value + (int(increment) if increment.is_integer() else increment)


class Increment(Elementwise, type="omni.graph.nodes.Increment"):
    """Adds `increment` to each number of `value`. The result keeps the type of `value`: the integer 4 plus 3.2 gives 7."""

    like = "value"

    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array to add to")
    increment: float = In(default=1.0, doc="number to add to each number of `value`")
    result: Any = Out(type=NUMERICS, doc="sum in the type of `value`, truncated toward 0 for an integer type")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the addition as a function of port values; integer results are truncated toward 0."""
        if is_real(output):
            return lift(operator.add, inputs, output, operator.add)
        return lift(lambda value, increment: np.trunc(value + increment), inputs, output, _incremented)
