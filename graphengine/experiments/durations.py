"""Durations in scenario files, such as `3s`, `500ms` or `2min`."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from graphengine.format.wording import shown

_UNITS = {"": 1.0, "ms": 1e-3, "s": 1.0, "min": 60.0}


def seconds(value: Any) -> Any:
    """Return a duration in seconds; a value that is no text is returned unchanged.

    Raises:
        ValueError: the text is no duration.
    """
    if not isinstance(value, str):
        return value
    match = re.fullmatch(r"([0-9]*\.?[0-9]+) ?(ms|s|min|)", value)
    if match is None:
        raise ValueError(f"expected a duration such as 3s, 500ms or 2min, got {shown(value)}")
    return float(match[1]) * _UNITS[match[2]]


Duration = Annotated[
    float, BeforeValidator(seconds, json_schema_input_type=float | str), Field(ge=0.0, allow_inf_nan=False)
]
"""A duration in seconds, or a text with a unit."""
Period = Annotated[Duration, Field(gt=0.0)]
