"""Nodes that compute with vectors and arrays of vectors (`omni.graph.nodes`)."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.node import BadValueError, In, Node, Out, PortType
from graphengine.nodes.data.broadcast import Operation, common, is_real, lift
from graphengine.nodes.data.elementwise import Elementwise
from graphengine.nodes.data.orientation import unit
from graphengine.nodes.data.unions import (
    DECIMAL_TUPLES,
    PLAIN_NUMERICS,
    REAL_TUPLES,
    REALS,
    VECTORS,
    arrays_of,
    with_arrays,
)

_VECTOR = "vector, or array of vectors"
_COMPONENTS = with_arrays(f"int|{REALS}")


def _vectors(count: int) -> str:
    return with_arrays("|".join(f"{base}[{count}]" for base in (*REALS.split("|"), "int")))


class _BreakVector(Node):
    """Base class of nodes that output the components of a vector, or of each vector in an array."""

    tuple_in: Any
    x: Any = Out(type=_COMPONENTS, couple="number", component=True)
    y: Any = Out(type=_COMPONENTS, couple="number", component=True)

    def components(self) -> Any:
        """Return the components in order; an array of vectors gives one array for each component."""
        vectors = self.tuple_in
        return vectors if type(vectors) is tuple else np.ascontiguousarray(vectors.T)


class BreakVector2(_BreakVector, type="omni.graph.nodes.BreakVector2"):
    """Splits a vector, point, normal or colour into its two components."""

    tuple_in: Any = In(type=_vectors(2), name="tuple", couple="number", required=True, doc=_VECTOR)

    def compute(self) -> None:
        """Set the outputs to the components of the vector."""
        self.x, self.y = self.components()


class BreakVector3(_BreakVector, type="omni.graph.nodes.BreakVector3"):
    """Splits a vector, point, normal or colour into its three components."""

    tuple_in: Any = In(type=_vectors(3), name="tuple", couple="number", required=True, doc=_VECTOR)
    z: Any = Out(type=_COMPONENTS, couple="number", component=True)

    def compute(self) -> None:
        """Set the outputs to the components of the vector."""
        self.x, self.y, self.z = self.components()


class BreakVector4(_BreakVector, type="omni.graph.nodes.BreakVector4"):
    """Splits a vector, point, normal, colour or quaternion into its four components."""

    tuple_in: Any = In(type=_vectors(4), name="tuple", couple="number", required=True, doc=_VECTOR)
    z: Any = Out(type=_COMPONENTS, couple="number", component=True)
    w: Any = Out(type=_COMPONENTS, couple="number", component=True)

    def compute(self) -> None:
        """Set the outputs to the components of the vector."""
        self.x, self.y, self.z, self.w = self.components()


class _MakeVector(Elementwise):
    """Base class of nodes that build a vector from its components."""

    x: Any = In(type=_COMPONENTS, required=True, doc="x component: number, or array of numbers")
    y: Any = In(type=_COMPONENTS, required=True, doc="y component: number, or array of numbers")

    @staticmethod
    def operation(*components: Any) -> Any:
        """Return vectors (..., n) built from n arrays of components."""
        return np.stack(np.broadcast_arrays(*components), axis=-1)

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that builds a tuple from numbers, or an array of tuples from arrays."""
        if output.array:
            return super().lifted(inputs, output)
        number = float if is_real(output) else int
        return lambda *components: tuple(map(number, components))

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: a tuple, or an array of tuples, with the widest base type of the components."""
        return common({**given, "": PortType("int", len(given))})


class MakeVector2(_MakeVector, type="omni.graph.nodes.MakeVector2"):
    """Builds a vector from two components, or an array of vectors from arrays of components."""

    tuple_out: Any = Out(type=_vectors(2), name="tuple", doc="vector (x, y)")


class MakeVector3(_MakeVector, type="omni.graph.nodes.MakeVector3"):
    """Builds a vector from three components, or an array of vectors from arrays of components."""

    z: Any = In(type=_COMPONENTS, required=True, doc="z component: number, or array of numbers")
    tuple_out: Any = Out(type=_vectors(3), name="tuple", doc="vector (x, y, z)")


class MakeVector4(_MakeVector, type="omni.graph.nodes.MakeVector4"):
    """Builds a vector from four components, or an array of vectors from arrays of components."""

    z: Any = In(type=_COMPONENTS, required=True, doc="z component: number, or array of numbers")
    w: Any = In(type=_COMPONENTS, required=True, doc="w component: number, or array of numbers")
    tuple_out: Any = Out(type=_vectors(4), name="tuple", doc="vector (x, y, z, w)")


class Magnitude(Elementwise, type="omni.graph.nodes.Magnitude"):
    """Computes the length of a vector, or the absolute value of a number."""

    input_in: Any = In(type=PLAIN_NUMERICS, name="input", required=True, doc="number, vector, or array of these")
    magnitude: Any = Out(type=PLAIN_NUMERICS)

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return a function that computes the length of a tuple, or the absolute value of a number."""
        if inputs[0].count == 1:
            return lift(np.abs, inputs, output, abs)
        if not output.array:
            return lambda vector: math.hypot(*vector)
        return lift(functools.partial(np.linalg.norm, axis=-1), inputs, output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: a number of the base type of the input, or a double for tuples of integers."""
        vector = given["input"]
        base = vector.base if vector.count == 1 or is_real(vector) else "double"
        return PortType(base, 1, vector.array)


class Normalize(Elementwise, type="omni.graph.nodes.Normalize"):
    """Scales a vector to length 1; a zero vector stays zero."""

    operation = unit

    vector: Any = In(type=with_arrays(REAL_TUPLES), required=True, doc="vector to normalize, or array of vectors")
    result: Any = Out(type=with_arrays(REAL_TUPLES), doc="unit vector, of the same type")


_DOT = f"{with_arrays(DECIMAL_TUPLES)}|{arrays_of(f'{REALS}|timecode')}"


def _dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):  # sum() rounds otherwise from Python 3.12 on
        total += x * y
    return total


class DotProduct(Elementwise, type="omni.graph.nodes.DotProduct"):
    """Computes the dot product of two vectors, or of each pair of vectors in two arrays.

    An array of numbers is treated as one vector.
    """

    on_tuples = _dot

    a: Any = In(type=_DOT, required=True, doc="first vector, or array of vectors")
    b: Any = In(type=_DOT, required=True, doc="second vector, or array of vectors; has the same size as `a`")
    product: Any = Out(
        type=with_arrays(f"{REALS}|timecode"), doc="dot product, or array with the dot product of each pair of vectors"
    )

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Return the dot products of vectors (..., n).

        Raises:
            BadValueError: `a` and `b` have different numbers of components.
        """
        if a.shape[-1] != b.shape[-1]:
            raise BadValueError("a, b", [a.shape[-1], b.shape[-1]], "of the same length")
        return np.sum(a * b, axis=-1)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: a number, or an array with one number per pair of vectors.

        Raises:
            ValueError: `a` and `b` are tuples of different lengths, or only one of them consists of tuples.
        """
        both = common(given)
        if len({operand.count > 1 for operand in given.values()}) > 1:
            raise ValueError(f"a is {given['a']} and b is {given['b']}; give vectors of the same length")
        return PortType(both.base, 1, both.array and both.count > 1)


def _cross(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


class CrossProduct(Elementwise, type="omni.graph.nodes.CrossProduct"):
    """Computes the cross product of two vectors, or of each pair of vectors in two arrays."""

    operation, on_tuples = np.cross, _cross

    a: Any = In(type=VECTORS, required=True, doc="first vector, or array of vectors")
    b: Any = In(type=VECTORS, required=True, doc="second vector, or array of as many vectors as `a`")
    product: Any = Out(type=VECTORS, doc="cross product `a` x `b`, perpendicular to `a` and `b`")


_POINTS = with_arrays("pointd[3]|pointf[3]|pointh[3]")


class Distance3D(Elementwise, type="omni.graph.nodes.Distance3D"):
    """Computes the distance between two points, or for two arrays of points, between the points of each pair."""

    on_tuples = math.dist

    a: Any = In(type=_POINTS, required=True, doc="first point, or array of points")
    b: Any = In(type=_POINTS, required=True, doc="second point, or array of points")
    distance: Any = Out(type=with_arrays(REALS), unit="m")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Return the distances between points (..., 3)."""
        return np.linalg.norm(a - b, axis=-1)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: a number, or an array with one number per pair of points."""
        return replace(common(given), count=1, role="")
