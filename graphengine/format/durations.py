"""Converts durations such as `0.1s`, `500ms` or `2min` to seconds."""

from __future__ import annotations

import re
from typing import Any

_UNITS = {"": 1.0, "s": 1.0, "ms": 1e-3, "min": 60.0}


def seconds(text: str) -> float:
    """Return a duration such as `10`, `10s`, `500ms` or `2min` in seconds.

    Raises:
        ValueError: the text is not a duration.
    """
    match = re.fullmatch(r"([0-9]*\.?[0-9]+) ?(s|ms|min|)", text.strip())
    if match is None:
        raise ValueError(f"{text.strip()!r} is not a time; write 10, 10s, 500ms or 2min")
    return float(match[1]) * _UNITS[match[2]]


def in_seconds(value: Any) -> Any:
    """Return a duration given as text in seconds, and any other value unchanged."""
    return seconds(value) if isinstance(value, str) else value
