"""Functions of angles and those that give angles (`omni.graph.nodes`), of each number in tuples and arrays; all in degrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Out
from graphengine.nodes.data.broadcast import Operation
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.unions import DECIMALS


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


class ToDeg(Elementwise, type="omni.graph.nodes.ToDeg"):
    """An angle in degrees."""

    operation = np.degrees
    on_numbers = math.degrees

    radians: Any = In(type=DECIMALS, required=True, unit="rad")
    degrees: Any = Out(type=DECIMALS, unit="deg")


class ToRad(Elementwise, type="omni.graph.nodes.ToRad"):
    """An angle in radians."""

    operation = np.radians
    on_numbers = math.radians

    degrees: Any = In(type=DECIMALS, required=True, unit="deg")
    radians: Any = Out(type=DECIMALS, unit="rad")
