"""Times such as `2s`, `500ms` and `2min`."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, Field


def seconds(text: str) -> float:
    """Return a time such as `10`, `10s`, `500ms` or `2min` in seconds.

    Raises:
        ValueError: the text is not a time.
    """
    match = re.fullmatch(r"([0-9]*\.?[0-9]+)(s|ms|min|)", text.strip())
    if match is None:
        raise ValueError(f"{text.strip()!r} is not a time; write 10, 10s, 500ms or 2min")
    return float(match[1]) * {"": 1.0, "s": 1.0, "ms": 1e-3, "min": 60.0}[match[2]]


def _seconds(value: Any) -> Any:
    return seconds(value) if isinstance(value, str) else value


Duration = Annotated[float, Field(ge=0, le=1e6), BeforeValidator(_seconds, json_schema_input_type=float | str)]
"""A time such as 2s, 500ms, 2min, or a number of seconds."""
