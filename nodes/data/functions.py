"""Functions of one or a few numbers (`omni.graph.nodes`), of each number in tuples and arrays. Angles are in degrees."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from graphengine.node import In, Out
from graphengine.types import Int, PortType
from nodes.data.broadcast import Operation, is_real
from nodes.data.elementwise import Elementwise
from nodes.data.unions import DECIMALS, INTEGRAL_TUPLES, NUMERICS, PLAIN_NUMERICS, with_arrays

_INTS = with_arrays(f"int|{INTEGRAL_TUPLES}")


class Absolute(Elementwise, type="omni.graph.nodes.Absolute"):
    """A value without its sign."""

    operation = on_numbers = abs

    input_in: Any = In(type=PLAIN_NUMERICS, name="input", required=True, doc="number, tuple or array")
    absolute: Any = Out(type=PLAIN_NUMERICS)

    def compute(self) -> None:
        """Take the sign away."""
        self.absolute = self.operate(self.input_in)


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
            ValueError: the bounds are the wrong way round.
        """
        if np.any(lower > upper):
            raise ValueError("a lower bound is above its upper bound")
        return np.clip(value, lower, upper)

    @staticmethod
    def on_numbers(value: Any, lower: Any, upper: Any) -> Any:
        """Clamp one number; NaN stays NaN.

        Raises:
            ValueError: the bounds are the wrong way round.
        """
        if lower > upper:
            raise ValueError("the lower bound is above the upper bound")
        return min(max(value, lower), upper)

    def compute(self) -> None:
        """Clamp."""
        self.result = self.operate(self.input_in, self.lower, self.upper)


class _ToWhole(Elementwise):
    """A real number made a whole one."""

    a: Any = In(type=DECIMALS, required=True, doc="number, tuple or array")
    result: Any = Out(type=_INTS, doc="of int; a number that no int can be is an error")

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Ints as many."""
        return PortType("int", given["a"].count, given["a"].array)

    def compute(self) -> None:
        """Make it whole."""
        self.result = self.operate(self.a)


class Floor(_ToWhole, type="omni.graph.nodes.Floor"):
    """The largest whole number that is not above a real one."""

    operation = np.floor

    @staticmethod
    def on_numbers(value: float) -> float:
        """Of one number; of one that is not finite itself."""
        return math.floor(value) if math.isfinite(value) else value


class Ceil(_ToWhole, type="omni.graph.nodes.Ceil"):
    """The smallest whole number that is not below a real one."""

    operation = np.ceil

    @staticmethod
    def on_numbers(value: float) -> float:
        """Of one number; of one that is not finite itself."""
        return math.ceil(value) if math.isfinite(value) else value


class Round(Elementwise, type="omni.graph.nodes.Round"):
    """A real number with fewer decimals; one that is half way goes to the even neighbour."""

    input_in: Any = In(type=DECIMALS, name="input", required=True, doc="number, tuple or array")
    decimals: Int = In(default=0, doc="how many digits stay after the point; negative ones round before it")
    output: Any = Out(type=DECIMALS, doc="rounded")

    @staticmethod
    def operation(value: Any, decimals: Any) -> Any:
        """Round arrays."""
        rounded = np.around(value, int(decimals))
        lost = np.isfinite(value) & ~np.isfinite(rounded)  # so many decimals that their power of ten is no double
        return np.where(lost, value if decimals > 0 else 0.0, rounded)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """That of the input."""
        return given["input"]

    def compute(self) -> None:
        """Round."""
        self.output = self.operate(self.input_in, self.decimals)


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

    def compute(self) -> None:
        """Raise."""
        self.result = self.operate(self.base, self.exponent)


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

    def compute(self) -> None:
        """Take the root."""
        self.result = self.operate(self.nth_root, self.value)


def _or_nan(function: Operation) -> Operation:
    """A function of Python numbers that is NaN where it has no value."""

    def total(number: float) -> float:
        try:
            found: float = function(number)
        except ValueError:
            return math.nan
        return found

    return total


def _of_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """A function of an angle in radians as one of degrees: of arrays, and of a number."""
    return lambda angles: many(np.radians(angles)), _or_nan(lambda angle: one(math.radians(angle)))


def _in_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """A function whose values are in radians as one with values in degrees: of arrays, and of a number."""
    return lambda values: np.degrees(many(values)), _or_nan(lambda value: math.degrees(one(value)))


class _OfAngle(Elementwise):
    """A function of angles in degrees."""

    value_in: Any = In(type=DECIMALS, name="value", required=True, unit="deg")
    value_out: Any = Out(type=DECIMALS, name="value", doc="of the type of the angle")

    def compute(self) -> None:
        """Compute."""
        self.value_out = self.operate(self.value_in)


class Sin(_OfAngle, type="omni.graph.nodes.Sin"):
    """Sine of an angle."""

    operation, on_numbers = _of_degrees(np.sin, math.sin)


class Cos(_OfAngle, type="omni.graph.nodes.Cos"):
    """Cosine of an angle."""

    operation, on_numbers = _of_degrees(np.cos, math.cos)


class Tan(_OfAngle, type="omni.graph.nodes.Tan"):
    """Tangent of an angle."""

    operation, on_numbers = _of_degrees(np.tan, math.tan)


class _ToAngle(Elementwise):
    """A function whose values are angles in degrees."""

    value_in: Any = In(type=DECIMALS, name="value", required=True, doc="number, tuple or array")
    value_out: Any = Out(type=DECIMALS, name="value", unit="deg")

    def compute(self) -> None:
        """Compute."""
        self.value_out = self.operate(self.value_in)


class Asin(_ToAngle, type="omni.graph.nodes.Asin"):
    """The angle from -90 to 90 degrees whose sine a number is; NaN beyond -1 to 1."""

    operation, on_numbers = _in_degrees(np.arcsin, math.asin)


class Acos(_ToAngle, type="omni.graph.nodes.Acos"):
    """The angle from 0 to 180 degrees whose cosine a number is; NaN beyond -1 to 1."""

    operation, on_numbers = _in_degrees(np.arccos, math.acos)


class Atan(_ToAngle, type="omni.graph.nodes.Atan"):
    """The angle from -90 to 90 degrees whose tangent a number is."""

    operation, on_numbers = _in_degrees(np.arctan, math.atan)


class ATan2(Elementwise, type="omni.graph.nodes.ATan2"):
    """The angle of a point from the x axis, from -180 to 180 degrees."""

    a: Any = In(type=DECIMALS, required=True, doc="y of the point")
    b: Any = In(type=DECIMALS, required=True, doc="x of the point")
    result: Any = Out(type=DECIMALS, unit="deg")

    @staticmethod
    def operation(y: Any, x: Any) -> Any:
        """Of arrays, in degrees."""
        return np.degrees(np.arctan2(y, x))

    @staticmethod
    def on_numbers(y: float, x: float) -> float:
        """Of one point, in degrees."""
        return math.degrees(math.atan2(y, x))

    def compute(self) -> None:
        """Compute."""
        self.result = self.operate(self.a, self.b)


class ToDeg(Elementwise, type="omni.graph.nodes.ToDeg"):
    """An angle in degrees."""

    operation = np.degrees
    on_numbers = math.degrees

    radians: Any = In(type=DECIMALS, required=True, unit="rad")
    degrees: Any = Out(type=DECIMALS, unit="deg")

    def compute(self) -> None:
        """Convert."""
        self.degrees = self.operate(self.radians)


class ToRad(Elementwise, type="omni.graph.nodes.ToRad"):
    """An angle in radians."""

    operation = np.radians
    on_numbers = math.radians

    degrees: Any = In(type=DECIMALS, required=True, unit="deg")
    radians: Any = Out(type=DECIMALS, unit="rad")

    def compute(self) -> None:
        """Convert."""
        self.radians = self.operate(self.degrees)
