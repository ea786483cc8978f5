"""Converts and checks values that the public API returns or accepts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graphengine.format.errors import UsageError
from graphengine.format.wording import listing, shown


def read_only(value: Any) -> Any:
    """Return the value; for an array, a read-only view."""
    if not isinstance(value, np.ndarray):
        return value
    view = value.view()
    view.flags.writeable = False
    return view


def plain(value: Any) -> Any:
    """Return the value converted to JSON types; arrays and tuples become lists.

    Raises:
        UsageError: the value cannot be converted to JSON.
    """
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise UsageError(f"expected a number, string, boolean, None, or a list or mapping of these, got {shown(value)}")


def check_choice(name: str, value: object, legal: Sequence[str]) -> None:
    """Raise UsageError if the value of the argument `name` is not one of the legal values."""
    if value not in legal:
        raise UsageError(f"{name}: unknown value {value!r}; {listing(legal)}")
