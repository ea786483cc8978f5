"""Trigonometric functions in degrees (`omni.graph.nodes`), applied to each number in tuples and arrays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Out
from graphengine.nodes.data.broadcast import Operation
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.unions import DECIMALS


def _or_nan(function: Operation) -> Operation:
    """Extend a function of Python numbers to return NaN outside its domain."""

    def total(number: float) -> float:
        try:
            found: float = function(number)
        except ValueError:
            return math.nan
        return found

    return total


def _of_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """Turn functions of radians, for arrays and for single numbers, into functions of degrees."""
    return lambda angles: many(np.radians(angles)), _or_nan(lambda angle: one(math.radians(angle)))


def _in_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """Turn functions with results in radians, for arrays and for single numbers, into ones with results in degrees."""
    return lambda values: np.degrees(many(values)), _or_nan(lambda value: math.degrees(one(value)))


class _OfAngle(Elementwise):
    """Base of functions of angles in degrees."""

    value_in: Any = In(type=DECIMALS, name="value", required=True, unit="deg", doc="angle: number, tuple or array")
    value_out: Any = Out(type=DECIMALS, name="value", doc="result, of the type of the angle")


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
    """Base of functions whose results are angles in degrees."""

    value_in: Any = In(
        type=DECIMALS, name="value", required=True, doc="argument of the function: number, tuple or array"
    )
    value_out: Any = Out(type=DECIMALS, name="value", unit="deg", doc="angle, of the type of the input")


class Asin(_ToAngle, type="omni.graph.nodes.Asin"):
    """Arc sine of a number, -90 to 90 degrees; NaN outside of -1 to 1."""

    operation, on_numbers = _in_degrees(np.arcsin, math.asin)


class Acos(_ToAngle, type="omni.graph.nodes.Acos"):
    """Arc cosine of a number, 0 to 180 degrees; NaN outside of -1 to 1."""

    operation, on_numbers = _in_degrees(np.arccos, math.acos)


class Atan(_ToAngle, type="omni.graph.nodes.Atan"):
    """Arc tangent of a number, -90 to 90 degrees."""

    operation, on_numbers = _in_degrees(np.arctan, math.atan)


class ATan2(Elementwise, type="omni.graph.nodes.ATan2"):
    """Angle from the x axis to the point (x, y), -180 to 180 degrees."""

    a: Any = In(type=DECIMALS, required=True, doc="y coordinate of the point")
    b: Any = In(type=DECIMALS, required=True, doc="x coordinate of the point")
    result: Any = Out(type=DECIMALS, unit="deg")

    @staticmethod
    def operation(y: Any, x: Any) -> Any:
        """Compute the angles of arrays of points, degrees."""
        return np.degrees(np.arctan2(y, x))

    @staticmethod
    def on_numbers(y: float, x: float) -> float:
        """Compute the angle of one point, degrees."""
        return math.degrees(math.atan2(y, x))


class ToDeg(Elementwise, type="omni.graph.nodes.ToDeg"):
    """Converts an angle from radians to degrees."""

    operation = np.degrees
    on_numbers = math.degrees

    radians: Any = In(type=DECIMALS, required=True, unit="rad")
    degrees: Any = Out(type=DECIMALS, unit="deg")


class ToRad(Elementwise, type="omni.graph.nodes.ToRad"):
    """Converts an angle from degrees to radians."""

    operation = np.radians
    on_numbers = math.radians

    degrees: Any = In(type=DECIMALS, required=True, unit="deg")
    radians: Any = Out(type=DECIMALS, unit="rad")
