"""Nodes that build, split, multiply, transpose and invert matrices (`omni.graph.nodes`).

Points are row vectors to the left of the matrix, so the translation of a 4 x 4 matrix is its fourth row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from graphengine.node import In, Out, PortType, Token
from graphengine.nodes.data.broadcast import Operation, common, lift
from graphengine.nodes.data.elementwise import Elementwise, TypedNode
from graphengine.nodes.data.unions import (
    DECIMAL_TUPLES,
    FRAMES,
    MATRICES,
    REAL_TUPLES,
    REALS,
    VECTORS,
    matrices,
    with_arrays,
)

_LARGEST_FLOAT = float(np.finfo(np.float32).max)


def square(flat: Any) -> Any:
    """Return matrices (..., n, n) from their numbers (..., n * n), given row by row."""
    size = math.isqrt(flat.shape[-1])
    return flat.reshape(*flat.shape[:-1], size, size)


def flat(squares: Any) -> Any:
    """Return the numbers (..., n * n) of matrices (..., n, n), row by row."""
    return squares.reshape(*squares.shape[:-2], squares.shape[-2] * squares.shape[-1])


class _MakeMatrix(Elementwise):
    """Base class of nodes that build a matrix from its rows."""

    @staticmethod
    def operation(*rows: Any) -> Any:
        """Return matrices built from arrays of rows. For four rows of three numbers, the fourth column is 0, 0, 0, 1."""
        size = len(rows)
        ends = [0.0] * (size - 1) + [1.0]
        whole = [
            row
            if row.shape[-1] == size
            else np.concatenate([row, np.full((*row.shape[:-1], size - row.shape[-1]), end)], axis=-1)
            for row, end in zip(rows, ends, strict=True)
        ]
        return flat(np.stack(np.broadcast_arrays(*whole), axis=-2))

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the output: a matrix, or an array of matrices if any row input is an array."""
        return PortType("double", len(given) ** 2, any(row.array for row in given.values()), "matrixd")


class MakeMatrix2(_MakeMatrix, type="omni.graph.nodes.MakeMatrix2"):
    """Builds a 2 x 2 matrix from its rows."""

    x: Any = In(type=with_arrays("double[2]"), required=True, doc="first row of the matrix")
    y: Any = In(type=with_arrays("double[2]"), required=True, doc="second row of the matrix")
    matrix: Any = Out(type=matrices(2))


class MakeMatrix3(_MakeMatrix, type="omni.graph.nodes.MakeMatrix3"):
    """Builds a 3 x 3 matrix from its rows."""

    x: Any = In(type=with_arrays("double[3]"), required=True, doc="first row of the matrix")
    y: Any = In(type=with_arrays("double[3]"), required=True, doc="second row of the matrix")
    z: Any = In(type=with_arrays("double[3]"), required=True, doc="third row of the matrix")
    matrix: Any = Out(type=matrices(3))


class MakeMatrix4(_MakeMatrix, type="omni.graph.nodes.MakeMatrix4"):
    """Builds a 4 x 4 matrix from its rows; if the rows have three numbers, the fourth column is 0, 0, 0, 1."""

    x: Any = In(type=with_arrays("double[4]|double[3]"), required=True, doc="first row of the matrix")
    y: Any = In(type=with_arrays("double[4]|double[3]"), required=True, doc="second row of the matrix")
    z: Any = In(type=with_arrays("double[4]|double[3]"), required=True, doc="third row of the matrix")
    w: Any = In(type=with_arrays("double[4]|double[3]"), required=True, doc="fourth row of the matrix")
    matrix: Any = Out(type=matrices(4))


class _BreakMatrix(TypedNode):
    """Base class of nodes that output the rows of a `size` x `size` matrix, or of each matrix in an array."""

    size: ClassVar[int]
    matrix: Any

    def width(self) -> int:
        """Return the number of columns in each output row."""
        return self.size

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the outputs: a row, or an array of rows if the input is an array."""
        return PortType("double", self.width(), given["matrix"].array)

    def compute(self) -> None:
        """Set the outputs to the rows of the matrix."""
        columns = [slice(start, start + self.width()) for start in range(0, self.size**2, self.size)]
        whole = self.matrix
        for name, part in zip("xyzw", columns, strict=False):
            setattr(self, name, whole[part] if type(whole) is tuple else np.ascontiguousarray(whole[:, part]))


class BreakMatrix2(_BreakMatrix, type="omni.graph.nodes.BreakMatrix2"):
    """Splits a 2 x 2 matrix into its two rows."""

    size = 2

    matrix: Any = In(type=matrices(2), required=True)
    x: Any = Out(type=with_arrays("double[2]"), doc="first row of the matrix")
    y: Any = Out(type=with_arrays("double[2]"), doc="second row of the matrix")


class BreakMatrix3(_BreakMatrix, type="omni.graph.nodes.BreakMatrix3"):
    """Splits a 3 x 3 matrix into its three rows."""

    size = 3

    matrix: Any = In(type=matrices(3), required=True)
    x: Any = Out(type=with_arrays("double[3]"), doc="first row of the matrix")
    y: Any = Out(type=with_arrays("double[3]"), doc="second row of the matrix")
    z: Any = Out(type=with_arrays("double[3]"), doc="third row of the matrix")


class BreakMatrix4(_BreakMatrix, type="omni.graph.nodes.BreakMatrix4"):
    """Splits a 4 x 4 matrix into its four rows, with all four numbers of each row or only the first three."""

    size = 4

    matrix: Any = In(type=matrices(4), required=True)
    output_type: Token = In(
        default="double[4]",
        tokens=("double[3]", "double[4]"),
        setup=True,
        doc="type of each row; double[3] leaves out the fourth column",
    )
    x: Any = Out(type=with_arrays("double[4]|double[3]"), doc="first row of the matrix")
    y: Any = Out(type=with_arrays("double[4]|double[3]"), doc="second row of the matrix")
    z: Any = Out(type=with_arrays("double[4]|double[3]"), doc="third row of the matrix")
    w: Any = Out(type=with_arrays("double[4]|double[3]"), doc="fourth row of the matrix")

    def width(self) -> int:
        """Return the number of columns that `outputType` selects, 3 or 4."""
        return int(self.output_type[-2])


_FACTORS = "|".join((with_arrays(f"{REAL_TUPLES}|{MATRICES}"), DECIMAL_TUPLES.removeprefix(f"{REAL_TUPLES}|"), FRAMES))


class MatrixMultiply(Elementwise, type="omni.graph.nodes.MatrixMultiply"):
    """Computes the matrix product of `a` and `b`. A vector `a` is a row vector, a vector `b` a column vector."""

    a: Any = In(type=_FACTORS, required=True, doc="left factor: matrix, row vector, or array of these")
    b: Any = In(type=_FACTORS, required=True, doc="right factor: matrix, column vector, or array of these")
    output: Any = Out(type=f"{_FACTORS}|{with_arrays(REALS)}", doc="`a` * `b`: matrix, vector, number, or array")

    def lifted(self, inputs: Sequence[PortType], output: PortType) -> Operation:
        """Return the matrix product as a function of port values of the given types."""
        a_is_matrix, b_is_matrix = map(_is_matrix, inputs)

        def multiply(a: Any, b: Any) -> Any:
            left = square(a) if a_is_matrix else a[..., None, :]
            right = square(b) if b_is_matrix else b[..., :, None]
            product = flat(left @ right)
            return product if a_is_matrix or b_is_matrix else product[..., 0]

        return lift(multiply, inputs, output)

    def result_type(self, given: Mapping[str, PortType]) -> PortType:
        """Return the type of the product: a matrix, a vector or a number.

        Raises:
            ValueError: the number of columns of `a` is not the number of rows of `b`.
        """
        a, b = given["a"], given["b"]
        sizes = [math.isqrt(one.count) if _is_matrix(one) else one.count for one in (a, b)]
        if sizes[0] != sizes[1]:
            raise ValueError(f"a is {a} and b is {b}; a must have as many columns as b has rows")
        array = a.array or b.array
        if _is_matrix(a) and _is_matrix(b):
            return replace(a, array=array, role="matrixd" if array or a.role != b.role else a.role)
        vector = b if _is_matrix(a) else a
        widest = common({"a": replace(a, count=1), "b": replace(b, count=1)}).base
        if not _is_matrix(a) and not _is_matrix(b):
            return PortType(widest, 1, array)
        return PortType(widest, vector.count, array, "" if array else vector.role)


def _is_matrix(port_type: PortType) -> bool:
    return port_type.role in ("matrixd", "frame", "transform") or port_type.count > 4


class Transpose(Elementwise, type="omni.graph.nodes.Transpose"):
    """Transposes a matrix."""

    matrix: Any = In(type=matrices(2, 3, 4), required=True, doc="matrix to transpose, or array of matrices")
    result: Any = Out(type=matrices(2, 3, 4), doc="transposed matrix, of the same type")

    @staticmethod
    def operation(matrix: Any) -> Any:
        """Return the transposed matrices; input and result are arrays (..., n * n), row by row."""
        return flat(np.swapaxes(square(matrix), -1, -2))


class InvertMatrix(Elementwise, type="omni.graph.nodes.OgnInvertMatrix"):
    """Inverts a matrix. A singular matrix gives the identity matrix times the largest 32 bit float."""

    matrix: Any = In(type=matrices(2, 3, 4), required=True, doc="matrix to invert, or array of matrices")
    inverted_matrix: Any = Out(type=matrices(2, 3, 4))

    @staticmethod
    def operation(matrix: Any) -> Any:
        """Return the inverse matrices; input and result are arrays (..., n * n), row by row."""
        squares = square(matrix)
        identity = np.eye(squares.shape[-1])
        finite = np.where(np.isfinite(squares).all(axis=(-2, -1), keepdims=True), squares, 0.0)
        singular = (np.linalg.matrix_rank(finite) < len(identity))[..., None, None]
        inverses = np.linalg.inv(np.where(singular, identity, finite))
        return flat(np.where(singular, _LARGEST_FLOAT * identity, inverses))


class TransformVector(Elementwise, type="omni.graph.nodes.TransformVector"):
    """Multiplies a row vector by a matrix. A 4 x 4 matrix also translates: the vector is treated as a point."""

    like = "vector"

    matrix: Any = In(type=matrices(3, 4), required=True, doc="3 x 3 or 4 x 4 matrix, or array of matrices")
    vector: Any = In(type=VECTORS, required=True, doc="row vector to transform, or array of vectors")
    result: Any = Out(type=VECTORS, doc="transformed vector, of the same type")

    @staticmethod
    def operation(matrix: Any, vector: Any) -> Any:
        """Return vectors (..., 3) multiplied by matrices, which are given as numbers (..., 9) or (..., 16)."""
        squares = square(matrix)
        if squares.shape[-1] == 3:
            return (vector[..., None, :] @ squares)[..., 0, :]
        moved = np.concatenate([vector, np.ones((*vector.shape[:-1], 1))], axis=-1)
        moved = (moved[..., None, :] @ squares)[..., 0, :]
        return moved[..., :3] / moved[..., 3:]
