"""OmniGraph's port types: their names, the Python type that represents each, and the conversions that wires make.

In this table, T is any scalar type:

| OmniGraph                            | Python                            |
|--------------------------------------|-----------------------------------|
| bool; int, uint, int64, uint64, uchar | bool; int                        |
| half, float, double, timecode        | float                             |
| token, string, path, objectId        | str                               |
| T[2], T[3], T[4]; vectord[3] and other roles | tuple of the scalars      |
| quatd[4]                             | tuple (x, y, z, w)                |
| T[], T[n][] of numbers               | numpy array of the exact dtype    |
| token[], string[]                    | tuple of str                      |
| target                               | tuple of prim paths               |
| uint64 as pointer, such as dataPtr   | the buffer itself; 0 for none     |
| any, unions                          | as for the resolved type          |
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "PortType", "UnionType", "Buffer", "String", "Target", "Token", "Tokens", "Bools", "UChar", "UChars", "Int", "Ints", "Int64",
    "UInt", "UInts", "UInt64", "Float", "Floats", "Float2", "Float3", "Double", "Doubles", "Double2", "Double3", "Double3s",
    "Double4s", "Matrix4d", "Point3fs", "Quaterniond", "Vector3d",
]  # fmt: skip
"""The names that `graphengine.node` exports to authors of nodes."""

INTEGERS = {"uchar": (0, 2**8 - 1), "int": (-(2**31), 2**31 - 1), "uint": (0, 2**32 - 1)}
INTEGERS |= {"int64": (-(2**63), 2**63 - 1), "uint64": (0, 2**64 - 1)}
"""Smallest and largest value of each integer type."""
_REALS = ("half", "float", "double", "timecode")
_TEXTS = ("token", "string", "path", "objectId")
_OTHERS = ("target", "execution", "any", "bundle")
_DTYPES = {"bool": np.bool_, "uchar": np.uint8, "int": np.int32, "uint": np.uint32, "int64": np.int64}
_DTYPES |= {"uint64": np.uint64, "half": np.float16, "float": np.float32, "double": np.float64, "timecode": np.float64}
_PRECISION = {"d": "double", "f": "float", "h": "half"}
ROLES = {"vector": (3,), "point": (3,), "normal": (3,), "color": (3, 4), "quat": (4,), "texcoord": (2, 3)}
"""Legal numbers of components for each role of a tuple, such as 3 or 4 for a colour."""
_MATRICES = {"matrixd": (2, 3, 4), "frame": (4,), "transform": (4,)}
_POINTER = "pointer"

_PATTERN = re.compile(r"(?P<name>[A-Za-z0-9]+?)(?P<tuple>\[[2-9]\])?(?P<array>\[\])?\Z")


@dataclass(frozen=True, slots=True)
class PortType:
    """A concrete port type, not a union.

    Attributes:
        base: scalar type, such as `double`.
        count: number of components of a tuple, such as 16 for a `matrixd[4]`; 1 for a scalar.
        array: whether the type is an array of such scalars or tuples.
        role: meaning of a tuple, such as `vector` or `quat`, which does not affect storage or wiring. A value with the role
            `pointer` is a Python buffer.
    """

    base: str
    count: int = 1
    array: bool = False
    role: str = ""

    def __str__(self) -> str:
        if self.role in _MATRICES:
            name, size = self.role, f"[{math.isqrt(self.count)}]"
        elif self.role in ROLES:
            name, size = self.role + self.base[0], f"[{self.count}]"
        else:
            name, size = self.base, f"[{self.count}]" if self.count > 1 else ""
        return f"{name}{size}{'[]' if self.array else ''}"

    @property
    def is_number(self) -> bool:
        """Whether the scalar type is a number or bool; arrays of this type are then numpy arrays."""
        return self.base in _DTYPES

    @property
    def dtype(self) -> Any:
        """The numpy dtype of arrays of this type; only for numbers and bool."""
        return _DTYPES[self.base]

    @property
    def zero(self) -> Any:
        """The initial value of an attribute of this type, as in OmniGraph: zero, empty, or the identity."""
        if self.array and self.is_number:
            return read_only(np.zeros((0,) if self.count == 1 else (0, self.count), self.dtype))
        if self.array or self.base == "target":
            return ()
        if self.role == "quat":
            return (0.0, 0.0, 0.0, 1.0)
        if self.role in _MATRICES:
            return tuple(np.eye(math.isqrt(self.count)).ravel().tolist())
        return _SCALAR_ZERO[self.base] if self.count == 1 else (_SCALAR_ZERO[self.base],) * self.count


_SCALAR_ZERO: dict[str, Any] = dict.fromkeys(INTEGERS, 0) | dict.fromkeys(_REALS, 0.0)
_SCALAR_ZERO |= dict.fromkeys(_TEXTS, "") | {"bool": False, "any": None, "bundle": None, "execution": None}


@dataclass(frozen=True, slots=True)
class UnionType:
    """A union of port types. It is resolved to one of these types by the port's wires, or by a type given in the graph file."""

    alternatives: tuple[PortType, ...]

    def __str__(self) -> str:
        return " | ".join(str(alternative) for alternative in self.alternatives)


ANY = PortType("any")
EXECUTION = PortType("execution")
TARGET = PortType("target")
POINTER = PortType("uint64", role=_POINTER)


@functools.cache
def parse(name: str) -> PortType | UnionType:
    """Return the type with this name, as in `.ogn` files: `double`, `vectord[3]`, `token[]`, `float[3][]`, `float|double`.

    Raises:
        ValueError: no port type has this name.
    """
    if "|" in name:
        parts = [parse(part.strip()) for part in name.split("|")]
        return UnionType(tuple(part for part in parts if isinstance(part, PortType)))
    match = _PATTERN.match(name)
    if match is None:
        raise ValueError(f"{name!r} is not a port type")
    word, count = match["name"], int(match["tuple"][1]) if match["tuple"] else 1
    array = match["array"] is not None
    if word == "path" or word in _OTHERS:
        if count > 1:
            raise ValueError(f"{name!r} is not a port type: there are no tuples of {word}")
        return PortType(word, 1, array)
    if word == "bool" or word in INTEGERS or word in _REALS or word in _TEXTS:
        return PortType(word, count, array)
    if word in _MATRICES and count in _MATRICES[word]:
        return PortType("double", count * count, array, word)
    role, precision = word[:-1], word[-1:]
    if role in ROLES and precision in _PRECISION and count in ROLES[role]:
        return PortType(_PRECISION[precision], count, array, role)
    raise ValueError(f"{name!r} is not a port type")


def coerce(value: Any, port_type: PortType) -> Any:
    """Return a literal, converted to the Python representation of a port type.

    Raises:
        TypeError: the literal has the wrong type; the message names the expected type.
        ValueError: a number is out of range, or a tuple has the wrong length.
    """
    if port_type.base in ("any", "bundle"):
        return value
    if port_type.role == _POINTER:
        return _buffer(value)
    if port_type.base == "target":
        paths = (value,) if isinstance(value, str) else value
        if not isinstance(paths, Sequence) or not all(isinstance(path, str) for path in paths):
            raise TypeError("expected a prim path or a list of prim paths")
        return tuple(path for path in paths if path)
    if not port_type.array:
        return _element(value, port_type)
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        raise TypeError(f"expected a list of {PortType(port_type.base, port_type.count, False, port_type.role)}")
    items = value.tolist() if isinstance(value, np.ndarray) else value
    elements = [_element(item, port_type) for item in items]
    if not port_type.is_number:
        return tuple(elements)
    shape = (len(elements),) if port_type.count == 1 else (len(elements), port_type.count)
    try:
        with np.errstate(over="raise"):
            return read_only(np.array(elements, port_type.dtype).reshape(shape))
    except FloatingPointError:
        raise ValueError(f"expected numbers within the range of a {port_type.base}") from None


def first_that_takes(value: Any, alternatives: Iterable[PortType]) -> tuple[PortType, Any]:
    """Return the first type that accepts a literal, and the literal converted to this type.

    Raises:
        TypeError: no type accepts the literal.
    """
    for alternative in alternatives:
        try:
            return alternative, coerce(value, alternative)
        except (TypeError, ValueError):
            continue
    raise TypeError("no type of the port accepts this value")


def _buffer(value: Any) -> Any:
    if type(value) is int and value == 0:
        return value
    try:
        memoryview(value)
    except TypeError:
        raise TypeError("expected a wire or the literal 0, because only a wire can provide a buffer") from None
    return value


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Make an array read-only in place and return the array; several ports can then share it."""
    array.setflags(write=False)
    return array


def _element(value: Any, port_type: PortType) -> Any:
    if port_type.count == 1:
        return _scalar(value, port_type.base)
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        raise TypeError(f"expected a list of {port_type.count} values")
    if port_type.role in _MATRICES and len(value) == math.isqrt(port_type.count):
        value = _joined_rows(value)
    if len(value) != port_type.count:
        raise ValueError(f"expected {port_type.count} values, got {len(value)}")
    return tuple(_scalar(item, port_type.base) for item in value)


def _joined_rows(rows: Sequence[Any] | NDArray[Any]) -> list[Any]:
    """Return the numbers of a matrix, given as a list of its rows, in one list."""
    if not all(isinstance(row, Sequence | np.ndarray) and not isinstance(row, str) for row in rows):
        raise TypeError("expected a matrix: a list of its rows, or one list of all its numbers")
    return [number for row in rows for number in row]


def _scalar(value: Any, base: str) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if base == "bool":
        if isinstance(value, bool):
            return value
        raise TypeError("expected true or false")
    if base in _TEXTS:
        if isinstance(value, str):
            return value
        raise TypeError("expected text" + (f'; write "{value}"' if isinstance(value, int | float) else ""))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError("expected a whole number" if base in INTEGERS else "expected a number")
    if base in INTEGERS:
        low, high = INTEGERS[base]
        if isinstance(value, float):
            raise TypeError("expected a whole number")
        if not low <= value <= high:
            raise ValueError(f"expected a value from {low} to {high}")
        return value
    try:
        return float(value)
    except OverflowError:
        raise ValueError("expected a number within the range of a double") from None


def conversion(source: PortType, target: PortType) -> str | None:
    """Return the name of the function in `CONVERTERS` that a wire from a source to a target type needs.

    The name is empty if no conversion is needed. Return None if the types cannot be wired. Wires convert bool and integers to
    int64 and double, and half and float to double; for other types, users insert a converter node. A timecode is a double. A
    target of type `any` accepts every type. Roles are ignored.
    """
    if target.base == "any" and not target.array:
        return ""
    if (source.count, source.array) != (target.count, target.array):
        return None
    source, target = (replace(end, base="double") if end.base == "timecode" else end for end in (source, target))
    if source.base == target.base:
        return ""
    if source.role == _POINTER:
        return None
    whole = source.base == "bool" or source.base in INTEGERS
    if target.base == "int64" and whole and source.base != "uint64":
        return "" if source.base != "bool" and not source.array else _converter("int64", source)
    if target.base == "double" and whole:
        return _converter("double", source)
    if target.base == "double" and source.base in ("half", "float"):
        return _converter("double", source) if source.array else ""
    return None


def _converter(base: str, source: PortType) -> str:
    if source.array:
        return f"{base}_array"
    return base if source.count == 1 else f"{base}_tuple"


CONVERTERS: dict[str, Any] = {
    "double": float,
    "int64": int,
    "double_tuple": lambda value: tuple(map(float, value)),
    "int64_tuple": lambda value: tuple(map(int, value)),
    "double_array": lambda value: value.astype(np.float64),
    "int64_array": lambda value: value.astype(np.int64),
}
"""The functions that convert values on wires, by the names that `conversion` returns."""


def plain(element: Any) -> Any:
    """Return an element of an array as a port value: a Python scalar, or a tuple of scalars if the elements are tuples."""
    value = element.tolist() if isinstance(element, np.generic | np.ndarray) else element
    return tuple(value) if isinstance(value, list) else value


def equal(one: Any, other: Any) -> bool:
    """Return whether two port values, which may be arrays, are equal; NaN equals NaN."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        both = isinstance(one, np.ndarray) and isinstance(other, np.ndarray)
        return both and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return one == other or (len(one) == len(other) and all(map(equal, one, other)))
    return bool(one == other or (one != one and other != other))


_VALUES = "bool|int|int64|uint64|uint|uchar|double|float|half|timecode|token|int[2]|int[3]|int[4]"
ELEMENTS = "|".join(
    (
        _VALUES,
        *(f"{real}[{count}]" for real in ("double", "float", "half") for count in (2, 3, 4)),
        *(f"{role}{bits}[3]" for role in ("color", "normal", "point", "vector") for bits in "dfh"),
        *(f"color{bits}[4]|quat{bits}[4]|texcoord{bits}[2]|texcoord{bits}[3]" for bits in "dfh"),
        "matrixd[2]|matrixd[3]|matrixd[4]|frame[4]|transform[4]",
    )
)
"""All types that the elements of an array can have, as one union. A literal without a type gets the first that accepts it."""
ARRAYS = "|".join(f"{element}[]" for element in ELEMENTS.split("|"))

Double = Annotated[float, parse("double")]
Float = Annotated[float, parse("float")]
Int = Annotated[int, parse("int")]
Int64 = Annotated[int, parse("int64")]
UInt = Annotated[int, parse("uint")]
UInt64 = Annotated[int, parse("uint64")]
UChar = Annotated[int, parse("uchar")]
Token = Annotated[str, parse("token")]
String = Annotated[str, parse("string")]
Target = Annotated[tuple[str, ...], parse("target")]
Tokens = Annotated[tuple[str, ...], parse("token[]")]
Ints = Annotated[NDArray[np.int32], parse("int[]")]
UInts = Annotated[NDArray[np.uint32], parse("uint[]")]
UChars = Annotated[NDArray[np.uint8], parse("uchar[]")]
Floats = Annotated[NDArray[np.float32], parse("float[]")]
Bools = Annotated[NDArray[np.bool_], parse("bool[]")]
Doubles = Annotated[NDArray[np.float64], parse("double[]")]
Vector3d = Annotated[tuple[float, float, float], parse("vectord[3]")]
Float2 = Annotated[tuple[float, float], parse("float[2]")]
Float3 = Annotated[tuple[float, float, float], parse("float[3]")]
Double2 = Annotated[tuple[float, float], parse("double[2]")]
Double3 = Annotated[tuple[float, float, float], parse("double[3]")]
Point3fs = Annotated[NDArray[np.float32], parse("pointf[3][]")]
Double3s = Annotated[NDArray[np.float64], parse("double[3][]")]
Double4s = Annotated[NDArray[np.float64], parse("double[4][]")]
Quaterniond = Annotated[tuple[float, float, float, float], parse("quatd[4]")]
Matrix4d = Annotated[tuple[float, ...], parse("matrixd[4]")]
Buffer = Annotated[Any, POINTER]
"""Type of pointer ports. The value is an object with Python's buffer protocol, such as a numpy array, or 0 for no buffer."""
