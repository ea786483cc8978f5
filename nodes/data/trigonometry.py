"""Nodes that apply a trigonometric function to each number of a value (`omni.graph.nodes`); angles are in degrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.node import In, Out
from graphengine.nodes.data.broadcast import Operation
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.unions import DECIMALS


def _or_nan(function: Operation) -> Operation:
    """Return a function that calls `function`, and returns NaN where `function` raises ValueError."""

    def total(number: float) -> float:
        try:
            found: float = function(number)
        except ValueError:
            return math.nan
        return found

    return total


def _of_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """Return functions of degrees for two functions of radians: `many` takes arrays, `one` takes single numbers."""
    return lambda angles: many(np.radians(angles)), _or_nan(lambda angle: one(math.radians(angle)))


def _in_degrees(many: Operation, one: Operation) -> tuple[Operation, Operation]:
    """Return functions that give degrees for two functions that give radians: `many` takes arrays, `one` single numbers."""
    return lambda values: np.degrees(many(values)), _or_nan(lambda value: math.degrees(one(value)))


class _OfAngle(Elementwise):
    """Base class of nodes that apply a function to an angle in degrees."""

    value_in: Any = In(type=DECIMALS, name="value", required=True, unit="deg", doc="angle: number, tuple or array")
    value_out: Any = Out(type=DECIMALS, name="value", doc="value of the function; has the type of the input")


class Sin(_OfAngle, type="omni.graph.nodes.Sin"):
    """Computes the sine of an angle."""

    operation, on_numbers = _of_degrees(np.sin, math.sin)


class Cos(_OfAngle, type="omni.graph.nodes.Cos"):
    """Computes the cosine of an angle."""

    operation, on_numbers = _of_degrees(np.cos, math.cos)


class Tan(_OfAngle, type="omni.graph.nodes.Tan"):
    """Computes the tangent of an angle."""

    operation, on_numbers = _of_degrees(np.tan, math.tan)


class _ToAngle(Elementwise):
    """Base class of nodes that compute an angle in degrees."""

    value_in: Any = In(type=DECIMALS, name="value", required=True, doc="argument: number, tuple or array")
    value_out: Any = Out(type=DECIMALS, name="value", unit="deg", doc="angle; has the type of the input")


class Asin(_ToAngle, type="omni.graph.nodes.Asin"):
    """Computes the arc sine of a number, from -90 to 90 degrees; NaN for numbers below -1 or above 1."""

    operation, on_numbers = _in_degrees(np.arcsin, math.asin)


class Acos(_ToAngle, type="omni.graph.nodes.Acos"):
    """Computes the arc cosine of a number, from 0 to 180 degrees; NaN for numbers below -1 or above 1."""

    operation, on_numbers = _in_degrees(np.arccos, math.acos)


class Atan(_ToAngle, type="omni.graph.nodes.Atan"):
    """Computes the arc tangent of a number, from -90 to 90 degrees."""

    operation, on_numbers = _in_degrees(np.arctan, math.atan)


class ATan2(Elementwise, type="omni.graph.nodes.ATan2"):
    """Computes the angle from the x axis to the point (x, y), from -180 to 180 degrees."""

    a: Any = In(type=DECIMALS, required=True, doc="y coordinate of the point")
    b: Any = In(type=DECIMALS, required=True, doc="x coordinate of the point")
    result: Any = Out(type=DECIMALS, unit="deg")

    @staticmethod
    def operation(y: Any, x: Any) -> Any:
        """Return the angles of points, in degrees; the arguments are arrays of their coordinates."""
        return np.degrees(np.arctan2(y, x))

    @staticmethod
    def on_numbers(y: float, x: float) -> float:
        """Return the angle of one point, in degrees."""
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
