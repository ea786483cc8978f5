"""Functions of one or a few numbers (`omni.graph.nodes`), of each number in tuples and arrays."""

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
    """A value without its sign."""

    operation = on_numbers = abs

    input_in: Any = In(type=PLAIN_NUMERICS, name="input", required=True, doc="number, tuple or array")
    absolute: Any = Out(type=PLAIN_NUMERICS)


class Clamp(Elementwise, type="omni.graph.nodes.Clamp"):
    """A value, or the bound that it is beyond."""

    input_in: Any = In(type=NUMERICS, name="input", required=True, doc="number, tuple or array")
    lower: Any = In(type=NUMERICS, required=True, doc="bound; must not be above the upper one")
    upper: Any = In(type=NUMERICS, required=True, doc="bound")
    result: Any = Out(type=NUMERICS, doc="what is nearest to the input from lower to upper")

    @staticmethod
    def operation(value: Any, lower: Any, upper: Any) -> Any:
        """Clamp arrays.

        Raises:
            BadValueError: the bounds are the wrong way round.
        """
        if np.any(lower > upper):
            raise BadValueError("lower, upper", (lower, upper), "in this order")
        return np.clip(value, lower, upper)

    @staticmethod
    def on_numbers(value: Any, lower: Any, upper: Any) -> Any:
        """Clamp one number; NaN stays NaN.

        Raises:
            BadValueError: the bounds are the wrong way round.
        """
        if lower > upper:
            raise BadValueError("lower, upper", (lower, upper), "in this order")
        return min(max(value, lower), upper)


class _ToWhole(Elementwise):
    """A real number made a whole one."""

    a: Any = In(type=DECIMALS, required=True, doc="number, tuple or array")
    result: Any = Out(type=_INTS, doc="of int; a number that no int can be is an error")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Ints as many."""
        return PortType("int", given["a"].count, given["a"].array)


def _of_finite(function: Operation) -> Operation:
    """A function of one number that leaves NaN and infinities as they are."""
    return lambda value: function(value) if math.isfinite(value) else value


class Floor(_ToWhole, type="omni.graph.nodes.Floor"):
    """The largest whole number that is not above a real one."""

    operation, on_numbers = np.floor, _of_finite(math.floor)


class Ceil(_ToWhole, type="omni.graph.nodes.Ceil"):
    """The smallest whole number that is not below a real one."""

    operation, on_numbers = np.ceil, _of_finite(math.ceil)


class Round(Elementwise, type="omni.graph.nodes.Round"):
    """A real number with fewer decimals; one that is half way goes to the neighbour that is farther from 0."""

    like = "input"

    input_in: Any = In(type=DECIMALS, name="input", required=True, doc="number, tuple or array")
    decimals: Int = In(default=0, doc="how many digits stay after the point; negative ones round before it")
    output: Any = Out(type=DECIMALS, doc="rounded")

    @staticmethod
    def operation(value: Any, decimals: Any) -> Any:
        """Round arrays."""
        power = np.float64(10.0) ** abs(int(decimals))
        scaled = value * power if decimals > 0 else value / power
        whole = np.trunc(scaled)
        whole += np.where(np.abs(scaled - whole) >= 0.5, np.sign(scaled), 0.0)
        rounded = whole / power if decimals > 0 else whole * power
        lost = np.isfinite(value) & ~np.isfinite(rounded)  # so many decimals that their power of ten is no double
        return np.where(lost, value if decimals > 0 else 0.0, rounded)


class _Power(Elementwise):
    """A function whose result is a double where the input is whole."""

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """That of the one input that takes several types, or doubles as many."""
        (base,) = given.values()
        return base if is_real(base) else PortType("double", base.count, base.array)


class Exponent(_Power, type="omni.graph.nodes.Exponent"):
    """A number raised to a whole power."""

    operation = np.power

    base: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    exponent: Int = In(default=2)
    result: Any = Out(type=NUMERICS, doc="a double where the base is whole")


class NthRoot(_Power, type="omni.graph.nodes.NthRoot"):
    """The number whose n-th power a value is; NaN of a negative value if n is even, infinite if n is 0."""

    nth_root: Int = In(default=2, doc="n; 2 is the square root")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array")
    result: Any = Out(type=NUMERICS, doc="a double where the value is whole")

    @staticmethod
    def operation(degree: Any, value: Any) -> Any:
        """Roots of arrays."""
        n = int(degree)
        if n == 0:
            return np.full_like(value, np.inf)
        if n in (2, 3):
            return np.sqrt(value) if n == 2 else np.cbrt(value)
        return np.copysign(np.power(np.abs(value), 1.0 / n), value) if n % 2 else np.power(value, 1.0 / n)


class Logarithm(_Power, type="omni.graph.nodes.Logarithm"):
    """The power to which a base is raised to give a value."""

    base: float = In(default=10.0, gt=0.0, doc="above 0, and not 1")
    value: Any = In(type=NUMERICS, required=True, doc="number, tuple or array; one that is not above 0 is an error")
    result: Any = Out(type=NUMERICS, doc="a double where the value is whole")

    @staticmethod
    def operation(base: Any, value: Any) -> Any:
        """Logarithms of arrays; those of powers of 10 and of 2 are whole.

        Raises:
            BadValueError: the base or a number has none.
        """
        if not base > 0.0 or base == 1.0:
            raise BadValueError("base", float(base), "above 0 and not 1")
        for wrong in np.ravel(value)[~(np.ravel(value) > 0.0)][:1]:
            raise BadValueError("value", float(wrong), "above 0")
        if base in (2.0, 10.0):
            return np.log2(value) if base == 2.0 else np.log10(value)
        return np.log(value) / np.log(base)
