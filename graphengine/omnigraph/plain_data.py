"""Values of a script as plain data: what USD, numpy and Python call a number, a text, a path or a tuple of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.diagnostics import shown

MAX_DEPTH = 6
"""Levels of lists; OmniGraph's deepest value is an array of matrices by rows."""


class UnknownError(Exception):
    """A value that cannot be known without Omniverse, or that no attribute can hold; says why."""


def plain_data(value: Any, depth: int = 0) -> Any:
    """None, bool, int, float, str, or lists of them.

    Raises:
        UnknownError: it is nothing of the kind.
    """
    if depth > MAX_DEPTH:
        raise UnknownError("it is nested too deep")
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return float(value)
    if isinstance(value, str):
        if "<unknown: " in value:
            raise UnknownError(f"it holds {value[:100]!r}")
        if any("\ud800" <= character <= "\udfff" for character in value):
            raise UnknownError("it is no text")
        return str(value)
    if isinstance(value, np.generic | np.ndarray):
        return plain_data(value.tolist(), depth)
    if isinstance(value, list | tuple | set | frozenset | range):
        ordered = sorted(value) if isinstance(value, set | frozenset) else value
        return [plain_data(item, depth + 1) for item in ordered]
    meant = getattr(type(value), "plain_data", None)
    if meant is None:
        raise UnknownError(f"no attribute holds {shown(value) if isinstance(value, dict) else type(value).__name__}")
    return plain_data(meant(value), depth + 1)
