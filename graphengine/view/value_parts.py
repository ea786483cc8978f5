"""Records of bodies that expressions read, and the numbers in values such as records, messages and arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

MOST_ELEMENTS, MOST_LEVELS = 8, 8
"""Maximum number of elements of an array, and of nested levels, to visit."""


@dataclass(frozen=True, slots=True)
class BodyPose:
    """Pose of a body in the world frame: position, m, and orientation, quaternion (x, y, z, w)."""

    position: tuple[float, ...]
    orientation: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class BodyVelocity:
    """Velocity of a body in the world frame: linear, m/s, and angular, rad/s."""

    linear: tuple[float, ...]
    angular: tuple[float, ...]


def numbers_in(value: Any, suffix: str = "", depth: int = 0) -> Iterator[str]:
    """Yield the suffixes of an expression, such as `.position.x` or `[0]`, that select the numbers in its value."""
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield suffix
    elif depth < MOST_LEVELS and is_dataclass(value):
        for field in fields(value):
            if not field.name.startswith("_"):
                yield from numbers_in(getattr(value, field.name), f"{suffix}.{field.name}", depth + 1)
    elif depth < MOST_LEVELS and isinstance(value, list | tuple | np.ndarray):
        for index, part in enumerate(value[:MOST_ELEMENTS]):
            yield from numbers_in(part, f"{suffix}[{index}]", depth + 1)
