"""Stubs of the value classes of `pxr` and `usdrt` with which scripts compute: paths, vectors, quaternions and matrices."""

from __future__ import annotations

import posixpath
from collections.abc import Sequence
from typing import Any, Self

import numpy as np

_SEVERAL = (Sequence, np.ndarray)


class SdfPath(str):
    """Stub of `Sdf.Path`, as a subclass of str."""

    __slots__ = ()

    def GetString(self) -> str:
        """Return the path as a string."""
        return str(self)

    GetText = GetString
    pathString = property(GetString)  # noqa: N815  a name of USD's

    @property
    def name(self) -> str:
        """Last element of the path."""
        return posixpath.basename(self)

    @property
    def isEmpty(self) -> bool:
        """Whether the path is empty."""
        return not self

    @staticmethod
    def IsValidPathString(path: str, *_: Any) -> bool:
        """Return whether a path is not empty; its syntax is checked only when the path is used."""
        return bool(path)

    def IsAbsolutePath(self) -> bool:
        """Return whether the path begins with `/`."""
        return self.startswith("/")

    def HasPrefix(self, prefix: str) -> bool:
        """Return whether `prefix` is this path or the path of an ancestor."""
        return prefix == "/" or self == prefix or self.startswith(f"{prefix}/")

    def GetParentPath(self) -> SdfPath:
        """Return the path of the parent prim."""
        return SdfPath(posixpath.dirname(self))

    def GetPrimPath(self) -> SdfPath:
        """Return the path without the name of a property."""
        return SdfPath(self.partition(".")[0])

    def AppendPath(self, other: str) -> SdfPath:
        """Return the path of the descendant at a relative path."""
        return SdfPath(posixpath.join(self, other))

    AppendChild = AppendPath

    def AppendProperty(self, name: str) -> SdfPath:
        """Return the path of this prim's property with the given name."""
        return SdfPath(f"{self}.{name}")

    def ReplaceName(self, name: str) -> SdfPath:
        """Return the path of the sibling with the given name."""
        return self.GetParentPath().AppendPath(name)


class Vector(tuple[float, ...]):
    """Stub of `Gf.Vec3d` and similar classes, as a tuple of the components."""

    __slots__ = ()
    size = 3

    def __new__(cls, *values: Any) -> Self:
        """Create a vector from numbers, a sequence of numbers, one number for all components, or zero."""
        many = tuple(values[0]) if len(values) == 1 and isinstance(values[0], _SEVERAL) else values
        return super().__new__(cls, (many or (0.0,)) * cls.size if len(many) < 2 else many)

    def __add__(self, other: Any) -> Self:
        return type(self)([a + b for a, b in zip(self, other, strict=True)])

    def __sub__(self, other: Any) -> Self:
        return type(self)([a - b for a, b in zip(self, other, strict=True)])

    def __mul__(self, factor: Any) -> Any:
        """Return the vector scaled by a number, or the dot product of two vectors."""
        if isinstance(factor, Sequence):
            return self.GetDot(factor)
        return type(self)([value * factor for value in self])

    __rmul__ = __mul__

    def __truediv__(self, factor: float) -> Self:
        return type(self)([value / factor for value in self])

    def __neg__(self) -> Self:
        return type(self)([-value for value in self])

    def GetDot(self, other: Sequence[float]) -> float:
        """Return the dot product with another vector."""
        return sum(a * b for a, b in zip(self, other, strict=True))

    def GetLength(self) -> float:
        """Return the Euclidean length of the vector."""
        return float(self.GetDot(self) ** 0.5)


class Vector2(Vector):
    """Stub of `Gf.Vec2d` and similar classes."""

    __slots__ = ()
    size = 2


class Vector4(Vector):
    """Stub of `Gf.Vec4d` and similar classes."""

    __slots__ = ()
    size = 4


class Quaternion:
    """Stub of `Gf.Quatd` and similar classes, created from w, x, y, z or from w and a vector."""

    def __init__(self, real: float = 1.0, *imaginary: Any) -> None:
        self.real = real
        self.imaginary = Vector(*imaginary)

    @classmethod
    def GetIdentity(cls) -> Quaternion:
        """Return the identity quaternion, which represents no rotation."""
        return cls(1.0, 0.0, 0.0, 0.0)

    def GetReal(self) -> float:
        """Return the scalar part."""
        return self.real

    def GetImaginary(self) -> Vector:
        """Return the vector part."""
        return self.imaginary

    def plain_data(self) -> list[float]:
        """Return the components in OmniGraph's order: x, y, z, w."""
        return [*self.imaginary, self.real]


class Matrix:
    """Stub of `Gf.Matrix4d` and similar classes, created from its numbers, its rows, or one number for the diagonal."""

    size = 4

    def __init__(self, *values: Any) -> None:
        first: Any = values[0] if values else 1.0
        if len(values) < 2 and isinstance(first, int | float):
            self.rows = [[float(first) if i == j else 0.0 for j in range(self.size)] for i in range(self.size)]
        else:
            rows = first if len(values) == 1 else values
            numbers = [number for row in rows for number in (row if isinstance(row, _SEVERAL) else [row])]
            self.rows = [list(numbers[i : i + self.size]) for i in range(0, len(numbers), self.size)]

    def SetIdentity(self) -> Matrix:
        """Set this matrix to the identity matrix and return it."""
        self.rows = type(self)().rows
        return self

    def plain_data(self) -> list[list[float]]:
        """Return the matrix as a list of rows."""
        return self.rows


class Matrix3(Matrix):
    """Stub of `Gf.Matrix3d` and similar classes."""

    size = 3


class Matrix2(Matrix):
    """Stub of `Gf.Matrix2d` and similar classes."""

    size = 2
