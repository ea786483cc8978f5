"""Pydantic types for the keys of a mover: points, shapes and loops."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from graphengine.format.wording import did_you_mean, shown

SHAPES = ("person", "forklift", "box")
"""Shapes of movers that need no mesh file."""


def _padded(value: Any) -> Any:
    if isinstance(value, list) and len(value) not in (2, 3):
        raise ValueError(f"a point has 2 or 3 coordinates, [x, y] or [x, y, z]; got {len(value)}")
    return [*value, 0.0] if isinstance(value, list) and len(value) == 2 else value


def keys_of_stop(value: Any) -> Any:
    """Return a point of a path, given as a list, as a dict with the key `at`; other values are unchanged."""
    return {"at": value} if isinstance(value, list) else value


def _shape(value: str) -> str:
    if value not in SHAPES and not re.search(r"[./]", value):
        near = did_you_mean(value, SHAPES) or f"legal: {', '.join(SHAPES)}, or the path of a mesh file"
        raise ValueError(f"unknown shape {value!r}; {near}")
    return value


def _loop(value: Any) -> Any:
    if type(value) is not bool and value != "there_and_back":
        raise ValueError(f"expected true, false or there_and_back, got {shown(value)}")
    return value


Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Corner = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
Point = Annotated[
    tuple[Coordinate, Coordinate, Coordinate],
    Field(strict=False),
    BeforeValidator(_padded, json_schema_input_type=tuple[float, float] | tuple[float, float, float]),
]
"""A point [x, y, z]; [x, y] stands for [x, y, 0]."""
Shape = Annotated[str, AfterValidator(_shape), Field(examples=[*SHAPES])]
Loop = Annotated[
    bool | Literal["there_and_back"],
    BeforeValidator(_loop, json_schema_input_type=bool | Literal["there_and_back"]),
]
