"""Encodes and decodes wide strings in CDR: the number of UTF-16 units, then each unit in 4 bytes, as all RMWs of ROS 2 do.

The code of ROS 2 is in `serialization_helpers.hpp` of rosidl_typesupport_fastrtps, and in `Serialization.cpp` of
rmw_cyclonedds_cpp. Fast CDR 2 itself encodes a `wchar_t` in 2 bytes, but ROS 2 does not use that encoding.
"""

from __future__ import annotations

import struct
from functools import partial
from typing import Any

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype

NAME = "graphengine/msg/WideString"
"""Name of the type that stands for wide strings in rosbags stores, because rosbags has no codec for wide strings."""
UNIT = 4
"""Size of a UTF-16 unit in CDR, bytes."""


def _units(text: str) -> bytes:
    return text.encode("utf-16-le", "surrogatepass")


def _size(position: int, text: Any, store: Any) -> int:
    return position + 4 + len(_units(text)) // 2 * UNIT


def _write(order: str, data: memoryview, position: int, text: str, store: Any) -> int:
    units = np.frombuffer(_units(text), "<u2").astype(f"{order}u{UNIT}").tobytes()
    struct.pack_into(f"{order}I", data, position, len(units) // UNIT)
    data[position + 4 : position + 4 + len(units)] = units
    return position + 4 + len(units)


def _read(order: str, data: memoryview, position: int, cls: Any, store: Any) -> tuple[str, int]:
    (count,) = struct.unpack_from(f"{order}I", data, position)
    position += 4
    end = position + count * UNIT
    if end > len(data):
        raise ValueError(f"a wide string of {count} units exceeds the remaining {len(data) - position} bytes")
    units = np.frombuffer(data[position:end], f"{order}u{UNIT}")
    if (units >> 16).any():
        raise ValueError("a unit of a wide string has more than 16 bits")
    return units.astype("<u2").tobytes().decode("utf-16-le", "replace"), end


_ROS1: Any = _size
"""Placeholder for the codec's functions for ROS 1; ROS 1 has no wide strings."""

_CODECS: list[Any] = [partial(function, order) for function in (_write, _read) for order in "<>"]
_FIELDS: list[Any] = [("text", (Nodetype.BASE, ("string", 0)))]
"""Fields of the type NAME, from which rosbags derives the alignment of the fields next to a wide string."""
CODEC: Msgdef[Any] = Msgdef(NAME, _FIELDS, str, 0, _size, *[*_CODECS, 0, *[_ROS1] * 7])
