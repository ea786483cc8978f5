"""Vectors put together, taken apart and measured (`omni.graph.nodes`), single ones and arrays of them."""

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

_VECTOR = "a vector, or an array of them"
_COMPONENTS = with_arrays(f"int|{REALS}")


def _vectors(count: int) -> str:
    return with_arrays("|".join(f"{base}[{count}]" for base in (*REALS.split("|"), "int")))


class _BreakVector(Node):
    """The components of a vector, or of each in an array."""

    tuple_in: Any
    x: Any = Out(type=_COMPONENTS, couple="number", component=True)
    y: Any = Out(type=_COMPONENTS, couple="number", component=True)

    def compute(self) -> None:
        """Take it apart."""
        vectors = self.tuple_in
        components = vectors if type(vectors) is tuple else np.ascontiguousarray(vectors.T)
        for name, component in zip("xyzw", components, strict=False):
            setattr(self, name, component)


class BreakVector2(_BreakVector, type="omni.graph.nodes.BreakVector2"):
    """The two components of a vector, whatever its role."""

    tuple_in: Any = In(type=_vectors(2), name="tuple", couple="number", required=True, doc=_VECTOR)


class BreakVector3(_BreakVector, type="omni.graph.nodes.BreakVector3"):
    """The three components of a vector, whatever its role."""

    tuple_in: Any = In(type=_vectors(3), name="tuple", couple="number", required=True, doc=_VECTOR)
    z: Any = Out(type=_COMPONENTS, couple="number", component=True)


class BreakVector4(_BreakVector, type="omni.graph.nodes.BreakVector4"):
    """The four components of a vector, whatever its role."""

    tuple_in: Any = In(type=_vectors(4), name="tuple", couple="number", required=True, doc=_VECTOR)
    z: Any = Out(type=_COMPONENTS, couple="number", component=True)
    w: Any = Out(type=_COMPONENTS, couple="number", component=True)


class _MakeVector(Elementwise):
    """A vector of its components."""

    x: Any = In(type=_COMPONENTS, required=True, doc="number, or array of numbers")
    y: Any = In(type=_COMPONENTS, required=True, doc="number, or array of numbers")

    @staticmethod
    def operation(*components: Any) -> Any:
        """Put arrays together."""
        return np.stack(np.broadcast_arrays(*components), axis=-1)

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """A tuple of numbers, or an array of arrays."""
        if output.array:
            return super().lifted(inputs, output)
        number = float if is_real(output) else int
        return lambda *components: tuple(map(number, components))

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """A tuple of the base that holds all components."""
        return common({**given, "": PortType("int", len(given))})


class MakeVector2(_MakeVector, type="omni.graph.nodes.MakeVector2"):
    """A vector of two components; of arrays, an array of vectors."""

    tuple_out: Any = Out(type=_vectors(2), name="tuple", doc="(x, y)")


class MakeVector3(_MakeVector, type="omni.graph.nodes.MakeVector3"):
    """A vector of three components; of arrays, an array of vectors."""

    z: Any = In(type=_COMPONENTS, required=True, doc="number, or array of numbers")
    tuple_out: Any = Out(type=_vectors(3), name="tuple", doc="(x, y, z)")


class MakeVector4(_MakeVector, type="omni.graph.nodes.MakeVector4"):
    """A vector of four components; of arrays, an array of vectors."""

    z: Any = In(type=_COMPONENTS, required=True, doc="number, or array of numbers")
    w: Any = In(type=_COMPONENTS, required=True, doc="number, or array of numbers")
    tuple_out: Any = Out(type=_vectors(4), name="tuple", doc="(x, y, z, w)")


class Magnitude(Elementwise, type="omni.graph.nodes.Magnitude"):
    """The length of a vector; of a number, what it is without its sign."""

    input_in: Any = In(type=PLAIN_NUMERICS, name="input", required=True, doc="number, vector or array of either")
    magnitude: Any = Out(type=PLAIN_NUMERICS)

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Lengths of tuples, or numbers without their signs."""
        if inputs[0].count == 1:
            return lift(np.abs, inputs, output, abs)
        if not output.array:
            return lambda vector: math.hypot(*vector)
        return lift(functools.partial(np.linalg.norm, axis=-1), inputs, output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """A number of the base of the input; the length of a tuple of whole numbers is a double."""
        vector = given["input"]
        base = vector.base if vector.count == 1 or is_real(vector) else "double"
        return PortType(base, 1, vector.array)


class Normalize(Elementwise, type="omni.graph.nodes.Normalize"):
    """A vector of length 1 in the direction of another; 0 of 0."""

    operation = unit

    vector: Any = In(type=with_arrays(REAL_TUPLES), required=True, doc="one, or an array of them")
    result: Any = Out(type=with_arrays(REAL_TUPLES), doc="of the type of the vector")


_DOT = f"{with_arrays(DECIMAL_TUPLES)}|{arrays_of(f'{REALS}|timecode')}"


def _dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    total = 0.0
    for x, y in zip(a, b, strict=True):  # sum() rounds otherwise from Python 3.12 on
        total += x * y
    return total


class DotProduct(Elementwise, type="omni.graph.nodes.DotProduct"):
    """The dot product of two vectors; of two arrays of vectors, those of the pairs; an array of numbers is one vector."""

    on_tuples = _dot

    a: Any = In(type=_DOT, required=True, doc="a vector, or an array of them")
    b: Any = In(type=_DOT, required=True, doc="as long as a")
    product: Any = Out(type=with_arrays(f"{REALS}|timecode"), doc="a number, or an array of them")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Dot products of arrays.

        Raises:
            BadValueError: they are not as long.
        """
        if a.shape[-1] != b.shape[-1]:
            raise BadValueError("a, b", [a.shape[-1], b.shape[-1]], "of one length")
        return np.sum(a * b, axis=-1)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """A number for each pair of vectors.

        Raises:
            ValueError: a and b are vectors of other sizes.
        """
        both = common(given)
        if len({operand.count > 1 for operand in given.values()}) > 1:
            raise ValueError(f"a is {given['a']} and b is {given['b']}; give vectors that are as long")
        return PortType(both.base, 1, both.array and both.count > 1)


def _cross(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


class CrossProduct(Elementwise, type="omni.graph.nodes.CrossProduct"):
    """The cross product of two vectors; of two arrays of vectors, those of the pairs."""

    operation, on_tuples = np.cross, _cross

    a: Any = In(type=VECTORS, required=True, doc="a vector, or an array of them")
    b: Any = In(type=VECTORS, required=True, doc="a vector, or an array of as many")
    product: Any = Out(type=VECTORS, doc="upright on a and b")


_POINTS = with_arrays("pointd[3]|pointf[3]|pointh[3]")


class Distance3D(Elementwise, type="omni.graph.nodes.Distance3D"):
    """How far two points are from each other."""

    on_tuples = math.dist

    a: Any = In(type=_POINTS, required=True, doc="a point, or an array of them")
    b: Any = In(type=_POINTS, required=True, doc="a point, or an array of them")
    distance: Any = Out(type=with_arrays(REALS), unit="m")

    @staticmethod
    def operation(a: Any, b: Any) -> Any:
        """Distances of arrays of points."""
        return np.linalg.norm(a - b, axis=-1)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """A number for each pair of points."""
        return replace(common(given), count=1, role="")
