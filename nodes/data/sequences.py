"""Operations on arrays of ports: numpy arrays, tuples of strings, and strings as arrays of their UTF-8 bytes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from graphengine.node import BadValueError, PortType, types

MAX_LENGTH = 10_000_000
"""Maximum length of an array or string that a node makes."""
INDEX = "index from 0; negative values count from the end, -1 is the last; out of range is an error"
"""Documentation of `index` ports."""
_BYTE = PortType("uchar")


def element_of(array: PortType) -> PortType:
    """The element type of an array type."""
    return _BYTE if not array.array else PortType(array.base, array.count, False, array.role)


def fits(given: PortType, element: PortType) -> bool:
    """Whether an array with this element type accepts a value of the given type."""
    return types.conversion(given, element) is not None


def as_array(value: Any) -> Any:
    """A port value as a sequence that can be sliced and joined: an array or a tuple of strings."""
    if isinstance(value, str):
        return np.frombuffer(value.encode(), np.uint8)
    if isinstance(value, np.ndarray) or (isinstance(value, tuple) and all(isinstance(text, str) for text in value)):
        return value
    return np.asarray(value)


def joined(like: Any, *parts: Any) -> Any:
    """The parts joined into an array of the same type as `like`; a part is an array or a list of elements.

    Raises:
        BadValueError: the result has too many elements.
    """
    checked_length("array", sum(map(len, parts)))
    if isinstance(like, str):
        return bytes(joined(as_array(like), *parts)).decode(errors="replace")
    if isinstance(like, tuple):
        return tuple(itertools.chain(*parts))
    kind = as_array(like)
    with np.errstate(over="ignore"):  # a number that is too large for a float becomes infinite
        return np.concatenate([np.asarray(part, kind.dtype).reshape(-1, *kind.shape[1:]) for part in parts])


def made(elements: Sequence[Any], element_type: PortType) -> Any:
    """An array of the given elements."""
    if not element_type.is_number:
        return tuple(elements)
    shape = (-1,) if element_type.count == 1 else (-1, element_type.count)
    with np.errstate(over="ignore"):
        return np.array(elements, element_type.dtype).reshape(shape)


def checked_length(port: str, length: int) -> int:
    """The length of a new array, with negative values replaced by 0.

    Args:
        port: OmniGraph's name of the input with the length.
        length: number of elements; negative values count as 0.

    Raises:
        BadValueError: the length is above the maximum.
    """
    if length > MAX_LENGTH:
        raise BadValueError(port, length, f"of {MAX_LENGTH} elements or fewer")
    return max(length, 0)


def position(index: int, length: int) -> int:
    """The position from 0 of `index` in a sequence of `length` elements; negative indices count from the end.

    Raises:
        BadValueError: the index is out of range.
    """
    if not -length <= index < length:
        raise BadValueError("index", index, f"{-length} to {length - 1}" if length else "into something not empty")
    return index % length


def zeros(array: Any, count: int) -> Any:
    """The given number of zeros or empty strings as elements for an array; none if it is negative."""
    if isinstance(array, tuple):
        return ("",) * count
    return np.zeros((max(count, 0), *array.shape[1:]), array.dtype)


def places(array: Any, value: Any) -> list[int]:
    """Positions of the elements equal to a value."""
    if isinstance(array, tuple):
        return [index for index, text in enumerate(array) if text == value]
    with np.errstate(over="ignore"):
        same = array == np.asarray(value, array.dtype)
    found: list[int] = np.flatnonzero(same.all(axis=1) if same.ndim == 2 else same).tolist()
    return found
