"""Checks whether the values of a message fit its type."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from graphengine.messages.interfaces import SCALARS, TEXTS, Description

_DTYPES: dict[str, tuple[str, ...]] = {"byte": ("uint8", "int8"), "char": ("uint8",)}

Fields = Callable[[str], Sequence[tuple[str, Description]]]
"""A function that takes the name of a message type, and returns the attribute name and the type of each field."""


def find_fault(value: Any, description: Description, place: str, fields: Fields) -> str:
    """Return a message about the first field or element of a value that does not fit its type, or an empty string.

    Args:
        value: a ROS message, or the value of a field.
        description: type of the value.
        place: name of the value in the message.
        fields: function that returns the fields of a message type.
    """
    kind, detail = description
    if kind == Nodetype.NAME:
        if getattr(value, "__msgtype__", None) != detail:
            return f"{place} is {type(value).__name__}, not {detail}"
        faults = (find_fault(getattr(value, name), field, f"{place}.{name}", fields) for name, field in fields(detail))
        return next(filter(None, faults), "")
    if kind == Nodetype.BASE:
        return _fault_of_scalar(value, detail, place)
    element, count = detail
    if hasattr(value, "__len__"):
        if kind == Nodetype.ARRAY and len(value) != count:
            return f"{place} has {len(value)} elements, not {count}"
        if kind == Nodetype.SEQUENCE and count and len(value) > count:
            return f"{place} has {len(value)} elements, at most {count} are allowed"
    if element[0] == Nodetype.BASE and element[1][0] not in TEXTS:
        return _fault_of_array(value, element[1][0], place)
    if not isinstance(value, list | tuple):
        return f"{place} is {type(value).__name__}, not a list"
    return next(filter(None, (find_fault(item, element, f"{place}[{i}]", fields) for i, item in enumerate(value))), "")


def _fault_of_array(value: Any, name: str, place: str) -> str:
    dtypes = _DTYPES.get(name, (name,))
    if not isinstance(value, np.ndarray):
        return f"{place} is {type(value).__name__}, not a numpy array of {dtypes[0]}"
    if value.dtype.name not in dtypes or value.ndim != 1 or not value.flags.c_contiguous:
        layout = "" if value.flags.c_contiguous else "non-contiguous "
        return f"{place} is a {layout}{value.ndim}-dimensional array of {value.dtype}, not a row of {dtypes[0]}"
    return ""


def _fault_of_scalar(value: Any, detail: tuple[str, int], place: str) -> str:
    name, bound = detail
    if name in TEXTS:
        if not isinstance(value, str):
            return f"{place} is {type(value).__name__}, not str"
        long = bound and len(value.encode()) > bound
        return f"{place} has {len(value.encode())} bytes, at most {bound} are allowed" if long else ""
    try:
        struct.pack(SCALARS[name], value)
    except (struct.error, OverflowError):
        return f"{place} is {value!r}, not a {name}"
    return ""
