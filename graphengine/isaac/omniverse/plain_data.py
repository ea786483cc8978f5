"""Converts a script's values to plain data: those of USD, numpy and Python."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.format.wording import shown
from graphengine.isaac.recorded_graph import MAX_ITEMS

MAX_TEXT = 1_000_000
"""Characters."""
MAX_DEPTH = 6
"""Levels of lists; OmniGraph's deepest value is an array of matrices by rows."""


_UNKNOWN = "<unknown: "
"""How texts begin that stand for what only Omniverse knows."""


def unknown(what: str) -> str:
    """The text that stands for something that only Omniverse knows."""
    return f"{_UNKNOWN}{what}>"


def is_unknown(value: Any) -> bool:
    """Whether something, or a part of a text, is what only Omniverse knows."""
    return _UNKNOWN in value if isinstance(value, str) else bool(getattr(type(value), "is_unknown", False))


class UnknownError(Exception):
    """A value that cannot be known without Omniverse, or that no attribute can hold; says why."""


def plain_data(value: Any) -> Any:
    """None, bool, int, float, str, or lists of them.

    Raises:
        UnknownError: it is nothing of the kind.
    """
    return _Reading().plain(value, 0)


class _Reading:
    """Of one value."""

    def __init__(self) -> None:
        self.items = 0

    def plain(self, value: Any, depth: int) -> Any:
        self.count(1)
        if depth > MAX_DEPTH:
            raise UnknownError("it is nested too deep")
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
            return self.plain(value.tolist(), depth)
        if isinstance(value, list | tuple | set | frozenset | range):
            ordered = sorted(value) if isinstance(value, set | frozenset) else value
            return [self.plain(item, depth + 1) for item in ordered]
        meant = getattr(type(value), "plain_data", None)
        if meant is None:
            kind = shown(value) if isinstance(value, dict) else type(value).__name__
            raise UnknownError(f"no attribute holds {kind}")
        return self.plain(meant(value), depth + 1)

    def count(self, items: int) -> None:
        self.items += items
        if self.items > MAX_ITEMS:
            raise UnknownError(f"it has more than {MAX_ITEMS} items")


def _whole(value: int) -> int:
    if not -(2**63) <= value < 2**64:
        raise UnknownError("it is no number of 64 bits")
    return value


def _text(value: str) -> str:
    if is_unknown(value):
        raise UnknownError(f"it holds {value[:100]!r}")
    if len(value) > MAX_TEXT:
        raise UnknownError(f"it has more than {MAX_TEXT} characters")
    if any("\ud800" <= character <= "\udfff" for character in value):
        raise UnknownError("it is no text")
    return str(value)
