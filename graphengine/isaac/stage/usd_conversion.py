"""Converts USD types to OmniGraph's type names, and USD values to plain data in OmniGraph's component order."""

from __future__ import annotations

import re
from typing import Any

from pxr import Gf, Sdf, Vt

from graphengine.isaac.recorded_graph import MAX_ITEMS
from graphengine.node import PortType, types

_QUATERNIONS = (Gf.Quatd, Gf.Quatf, Gf.Quath)
_MATRICES = (Gf.Matrix2d, Gf.Matrix3d, Gf.Matrix4d)
_VECTORS = tuple(getattr(Gf, f"Vec{count}{kind}") for count in (2, 3, 4) for kind in "dfhi")
_SEQUENCES: Any = (
    list,
    tuple,
    *(kind for name, kind in vars(Vt).items() if name.endswith("Array") and isinstance(kind, type)),
)

_TYPES = (
    (re.compile(r"(double|float|half|int)([234])"), r"\1[\2]"),
    (re.compile(r"(vector|point|normal|color|texcoord)([234])([dfh])"), r"\1\3[\2]"),
    (re.compile(r"quat([dfh])"), r"quat\1[4]"),
    (re.compile(r"(matrix)([234])d"), r"\1d[\2]"),
    (re.compile(r"frame4d"), "frame[4]"),
    (re.compile(r"asset"), "token"),
)


def type_name(name: str) -> str:
    """Return OmniGraph's name for a USD type name, such as `vectord[3][]` for `vector3d[]`."""
    element = name.removesuffix("[]").lower()
    for pattern, replacement in _TYPES:
        if pattern.fullmatch(element):
            element = pattern.sub(replacement, element)
            break
    return element + ("[]" if name.endswith("[]") else "")


def plain_value(value: Any, type: str) -> Any:
    """Return a USD value as None, bool, int, float, str, or nested lists of them.

    A quaternion becomes [x, y, z, w], a matrix a list of rows. A float or half becomes the shortest decimal number that rounds to
    the same value in its own precision: 0.1, not 0.10000000149011612.

    Args:
        value: value from USD's Python API.
        type: OmniGraph's type name of the value.

    Raises:
        ValueError: the value has another type, or more than `MAX_ITEMS` items.
    """
    data = _plain(value)
    try:
        port_type = types.parse(type)
    except ValueError:  # the unknown type is reported where the value is used
        return data
    if isinstance(port_type, PortType) and port_type.base in ("float", "half"):
        return _shortened(data, port_type.dtype)
    return data


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, _QUATERNIONS):
        return [*map(float, value.GetImaginary()), float(value.GetReal())]
    if isinstance(value, _MATRICES):
        return [[float(number) for number in value.GetRow(row)] for row in range(value.dimension[0])]
    if isinstance(value, _VECTORS):
        return list(value)
    if isinstance(value, Sdf.AssetPath):
        return str(value.path)
    if isinstance(value, Sdf.TimeCode):
        return float(value.GetValue())
    if isinstance(value, _SEQUENCES):
        if len(value) > MAX_ITEMS:
            raise ValueError(f"it has more than {MAX_ITEMS} items")
        return [_plain(item) for item in value]
    raise ValueError(f"a port cannot hold a {type(value).__name__}")


def _shortened(data: Any, dtype: Any) -> Any:
    if isinstance(data, list):
        return [_shortened(item, dtype) for item in data]
    return float(str(dtype(data))) if isinstance(data, float) else data
