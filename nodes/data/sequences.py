"""Functions for port values that are arrays: numpy arrays, tuples of strings, and strings as arrays of UTF-8 bytes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from graphengine.node import BadValueError, PortType, types

MAX_LENGTH = 10_000_000
"""Maximum number of elements or characters in an array or string that a node outputs."""
INDEX = "index from 0; negative values count from the end, -1 is the last; a value out of range is an error"
"""Text for the `doc` of inputs that are an index."""
_BYTE = PortType("uchar")


def element_of(array: PortType) -> PortType:
    """Return the element type of an array type; for the type string, return uchar."""
    return _BYTE if not array.array else PortType(array.base, array.count, False, array.role)


def fits(given: PortType, element: PortType) -> bool:
    """Return whether a value of type `given` converts to the type `element`."""
    return types.conversion(given, element) is not None


def as_array(value: Any) -> Any:
    """Return a port value as a sequence that can be sliced and joined: a numpy array or a tuple of strings."""
    if isinstance(value, str):
        return np.frombuffer(value.encode(), np.uint8)
    if isinstance(value, np.ndarray) or (isinstance(value, tuple) and all(isinstance(text, str) for text in value)):
        return value
    return np.asarray(value)


def joined(like: Any, *parts: Any) -> Any:
    """Concatenate arrays and lists of elements, and return one array of the same type as `like`.

    Raises:
        BadValueError: the joined array has more than `MAX_LENGTH` elements.
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
    """Return an array with the given elements. All elements must convert to the element type."""
    if not element_type.is_number:
        return tuple(elements)
    shape = (-1,) if element_type.count == 1 else (-1, element_type.count)
    with np.errstate(over="ignore"):
        return np.array(elements, element_type.dtype).reshape(shape)


def checked_length(port: str, length: int) -> int:
    """Return the length of a new array after checking it; a negative length becomes 0.

    Args:
        port: OmniGraph name of the input that determines the length, for the error message.
        length: number of elements of the new array.

    Raises:
        BadValueError: the length is above `MAX_LENGTH`.
    """
    if length > MAX_LENGTH:
        raise BadValueError(port, length, f"of {MAX_LENGTH} elements or fewer")
    return max(length, 0)


def position(index: int, length: int) -> int:
    """Return `index` as a position from 0 in a sequence of `length` elements; a negative index counts from the end.

    Raises:
        BadValueError: the index is out of range.
    """
    if not -length <= index < length:
        empty = "an index into an array or string that is not empty"
        raise BadValueError("index", index, f"from {-length} to {length - 1}" if length else empty)
    return index % length


def zeros(array: Any, count: int) -> Any:
    """Return `count` zeros, or `count` empty strings if `array` holds strings; a negative count is treated as 0."""
    if isinstance(array, tuple):
        return ("",) * count
    return np.zeros((max(count, 0), *array.shape[1:]), array.dtype)


def places(array: Any, value: Any) -> list[int]:
    """Return the indices of all array elements that equal a value, in ascending order."""
    if isinstance(array, tuple):
        return [index for index, text in enumerate(array) if text == value]
    with np.errstate(over="ignore"):
        same = array == np.asarray(value, array.dtype)
    found: list[int] = np.flatnonzero(same.all(axis=1) if same.ndim == 2 else same).tolist()
    return found
