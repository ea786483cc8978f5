"""Converts values in a script (USD, numpy or Python objects) to plain data: numbers, strings and lists."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.format.wording import shown
from graphengine.isaac.recorded_graph import MAX_ITEMS

MAX_TEXT = 1_000_000
"""Maximum length of a string, characters."""
MAX_DEPTH = 6
"""Maximum nesting depth of lists; OmniGraph's deepest value is an array of matrices, each a list of rows."""


_UNKNOWN = "<unknown: "
"""Prefix of the placeholder texts for values that only Omniverse knows."""


def unknown(what: str) -> str:
    """Return the placeholder text `<unknown: WHAT>` for a value that only Omniverse knows."""
    return f"{_UNKNOWN}{what}>"


def is_unknown(value: Any) -> bool:
    """Return whether a value is a stub, or a string that contains the placeholder of an unknown value."""
    return _UNKNOWN in value if isinstance(value, str) else bool(getattr(type(value), "is_unknown", False))


class UnknownError(Exception):
    """A value cannot be recorded: only Omniverse knows it, or no attribute can hold it. The message is the reason."""


def plain_data(value: Any) -> Any:
    """Return a value as None, bool, int, float, str, or nested lists of them.

    Raises:
        UnknownError: the value cannot be converted.
    """
    return _Reading().plain(value, 0)


class _Reading:
    """Conversion of one value, which counts all its items and allows `MAX_ITEMS`."""

    def __init__(self) -> None:
        self.items = 0

    def plain(self, value: Any, depth: int) -> Any:
        self.count(1)
        if depth > MAX_DEPTH:
            raise UnknownError("it is nested too deeply")
        if value is None or isinstance(value, bool):
            return value
        if isinstance(value, int):
            return _whole(int(value))
        if isinstance(value, float):
            return float(value)
        if isinstance(value, str):
            return _text(value)
        if isinstance(value, np.generic | np.ndarray):
            self.count(value.size)
            self.items -= value.size + 1  # they are counted again
            return self.plain(value.tolist(), depth)
        if isinstance(value, list | tuple | set | frozenset | range):
            ordered = sorted(value) if isinstance(value, set | frozenset) else value
            return [self.plain(item, depth + 1) for item in ordered]
        meant = getattr(type(value), "plain_data", None)
        if meant is None:
            kind = shown(value) if isinstance(value, dict) else type(value).__name__
            raise UnknownError(f"an attribute cannot hold {kind}")
        return self.plain(meant(value), depth + 1)

    def count(self, items: int) -> None:
        self.items += items
        if self.items > MAX_ITEMS:
            raise UnknownError(f"it has more than {MAX_ITEMS} items")


def _whole(value: int) -> int:
    if not -(2**63) <= value < 2**64:
        raise UnknownError("it does not fit into 64 bits")
    return value


def _text(value: str) -> str:
    if is_unknown(value):
        raise UnknownError(f"it contains {value[:100]!r}, which only Omniverse knows")
    if len(value) > MAX_TEXT:
        raise UnknownError(f"it has more than {MAX_TEXT} characters")
    if any("\ud800" <= character <= "\udfff" for character in value):
        raise UnknownError("it contains characters that are not valid Unicode")
    return str(value)
