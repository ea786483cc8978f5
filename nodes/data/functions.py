"""Nodes that apply a mathematical function to each number of a value (`omni.graph.nodes`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from graphengine.node import BadValueError, In, Int, Out, PortType
from graphengine.nodes.data.broadcast import Operation, is_real
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.unions import DECIMALS, INTEGRAL_TUPLES, NUMERICS, PLAIN_NUMERICS, with_arrays

_INTS = with_arrays(f"int|{INTEGRAL_TUPLES}")


class Absolute(Elementwise, type="omni.graph.nodes.Absolute"):
    """Computes the absolute value of each number of a value."""

    operation = on_numbers = abs

    input_in: Any = In(type=PLAIN_NUMERICS, name="input", required=True, doc="number, tuple or array")
    absolute: Any = Out(type=PLAIN_NUMERICS)


class Clamp(Elementwise, type="omni.graph.nodes.Clamp"):
    """Limits each number of a value to the range from `lower` to `upper`."""

    input_in: Any = In(type=NUMERICS, name="input", required=True, doc="number, tuple or array to limit")
    lower: Any = In(type=NUMERICS, required=True, doc="lower bound; must not be above `upper`")
    upper: Any = In(type=NUMERICS, required=True, doc="upper bound")
    result: Any = Out(type=NUMERICS, doc="`input` limited to the range from `lower` to `upper`")

    @staticmethod
    def operation(value: Any, lower: Any, upper: Any) -> Any:
        """Return the numbers of an array limited to their bounds.

        Raises:
            BadValueError: `lower` is above `upper`.
        """
        if np.any(lower > upper):
            raise BadValueError("lower, upper", (lower, upper), "in ascending order")
        return np.clip(value, lower, upper)

    @staticmethod
    def on_numbers(value: Any, lower: Any, upper: Any) -> Any:
        """Return a number limited to its bounds; NaN stays NaN.

        Raises:
            BadValueError: `lower` is above `upper`.
        """
        if lower > upper:
            raise BadValueError("lower, upper", (lower, upper), "in ascending order")
        return min(max(value, lower), upper)


class _ToWhole(Elementwise):
    """Base class of nodes that round real numbers to integers."""

    a: Any = In(type=DECIMALS, required=True, doc="number, tuple or array to round")
    result: Any = Out(type=_INTS, doc="rounded numbers, of type int; a number out of the range of int is an error")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: int, in the shape of the input."""
        return PortType("int", given["a"].count, given["a"].array)


def _of_finite(function: Operation) -> Operation:
    """Return a function that applies `function` to finite numbers and returns NaN and infinities unchanged."""
    return lambda value: function(value) if math.isfinite(value) else value


class Floor(_ToWhole, type="omni.graph.nodes.Floor"):
    """Rounds real numbers down to integers."""

    operation, on_numbers = np.floor, _of_finite(math.floor)


class Ceil(_ToWhole, type="omni.graph.nodes.Ceil"):
    """Rounds real numbers up to integers."""

    operation, on_numbers = np.ceil, _of_finite(math.ceil)


class Round(Elementwise, type="omni.graph.nodes.Round"):
    """Rounds real numbers to a given number of decimals; halves are rounded away from 0."""

    like = "input"

    input_in: Any = In(type=DECIMALS, name="input", required=True, doc="number, tuple or array to round")
    decimals: Int = In(default=0, doc="number of digits after the decimal point; -1 rounds to tens, -2 to hundreds")
    output: Any = Out(type=DECIMALS, doc="rounded value, of the type of `input`")

    @staticmethod
    def operation(value: Any, decimals: Any) -> Any:
        """Return the numbers of an array rounded to `decimals` digits, halves away from 0."""
        power = np.float64(10.0) ** abs(int(decimals))
        scaled = value * power if decimals > 0 else value / power
        whole = np.trunc(scaled)
        whole += np.where(np.abs(scaled - whole) >= 0.5, np.sign(scaled), 0.0)
        rounded = whole / power if decimals > 0 else whole * power
        lost = np.isfinite(value) & ~np.isfinite(rounded)  # so many decimals that their power of ten is no double
        return np.where(lost, value if decimals > 0 else 0.0, rounded)


class _Power(Elementwise):
    """Base class of nodes that compute real numbers from one value; integers give doubles."""

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the input, with the base type double in place of integers."""
        (base,) = given.values()
        return base if is_real(base) else PortType("double", base.count, base.array)


class Exponent(_Power, type="omni.graph.nodes.Exponent"):
    """Raises each number of a value to an integer power."""

    operation = np.power

    base: Any = In(type=NUMERICS, required=True, doc="number, tuple or array to raise to the power")
    exponent: Int = In(default=2)
    result: Any = Out(type=NUMERICS, doc="`base` to the power of `exponent`; doubles if `base` consists of integers")


class NthRoot(_Power, type="omni.graph.nodes.NthRoot"):
    """Computes the n-th root of a value, where n is `nthRoot`.

    The root of a negative number is NaN if n is even. All roots are infinite if n is 0.
    """

    nth_root: Int = In(default=2, doc="degree of the root: 2 for the square root, 3 for the cube root")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array to take the root of")
    result: Any = Out(type=NUMERICS, doc="root of `value`; doubles if `value` consists of integers")

    @staticmethod
    def operation(degree: Any, value: Any) -> Any:
        """Return the roots of the numbers of an array."""
        n = int(degree)
        if n == 0:
            return np.full_like(value, np.inf)
        if n in (2, 3):
            return np.sqrt(value) if n == 2 else np.cbrt(value)
        return np.copysign(np.power(np.abs(value), 1.0 / n), value) if n % 2 else np.power(value, 1.0 / n)


class Logarithm(_Power, type="omni.graph.nodes.Logarithm"):
    """Computes the logarithm of a value to a given base."""

    base: float = In(default=10.0, gt=0.0, doc="base of the logarithm; must be above 0 and other than 1")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array; all numbers must be above 0")
    result: Any = Out(type=NUMERICS, doc="logarithm of `value`; doubles if `value` consists of integers")

    @staticmethod
    def operation(base: Any, value: Any) -> Any:
        """Return the logarithms of the numbers of an array; for base 2 and base 10, logarithms of powers of the base are exact.

        Raises:
            BadValueError: `base` is 1 or not above 0, or a number is not above 0.
        """
        if not base > 0.0 or base == 1.0:
            raise BadValueError("base", float(base), "above 0 and not 1")
        for wrong in np.ravel(value)[~(np.ravel(value) > 0.0)][:1]:
            raise BadValueError("value", float(wrong), "above 0")
        if base in (2.0, 10.0):
            return np.log2(value) if base == 2.0 else np.log10(value)
        return np.log(value) / np.log(base)
