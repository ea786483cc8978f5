"""Which entities a query means: by name, category, tags, and by what they overlap."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Sequence
from typing import Any

from graphengine.control.simulation_interfaces.results import FAILED, UNSUPPORTED, RefusedError
from graphengine.devices.entity import Box

MAX_PATTERN = 1000
MAX_UNROLLED = 100_000
"""Characters of an expression whose counted repetitions are written out, as they are before it is used."""
PATIENCE = 0.1
"""Seconds that all names together may take: an expression can be made to take for ever."""
EMPTY, BOX, CONVEX_HULL, SPHERE = range(4)
_ALL = 1
"""`TagsFilter.FILTER_MODE_ALL`."""


def name_filter(pattern: str, names: Sequence[str]) -> list[str]:
    """The names in which a regular expression is found; POSIX's character classes are known.

    Raises:
        RefusedError: it is none, is too long, or takes too long.
    """
    if not pattern:
        return list(names)
    if len(pattern) > MAX_PATTERN:
        raise RefusedError(FAILED, f"a filter has at most {MAX_PATTERN} characters")
    if len(pattern) * _repetitions(pattern) > MAX_UNROLLED:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} repeats too much")
    import regex  # Python's own cannot be stopped

    try:
        expression, deadline = regex.compile(pattern), time.monotonic() + PATIENCE
        return [name for name in names if expression.search(name, timeout=max(deadline - time.monotonic(), 0.0))]
    except (regex.error, OverflowError, RecursionError) as error:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} is no regular expression: {error}") from None
    except TimeoutError:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} takes too long") from None


def _repetitions(pattern: str) -> int:
    """How often the innermost part of an expression is written out at most: all may lie within each other."""
    counts = (re.findall(r"[0-9]+", braces) for braces in re.findall(r"\{[^{}]*\}", pattern))
    return math.prod(max(*map(int, found), 1) for found in counts if found)


def has_tags(wanted: Any, tags: Sequence[str]) -> bool:
    """Whether tags match a TagsFilter."""
    found = [tag in tags for tag in wanted.tags]
    return not found or (all(found) if wanted.filter_mode == _ALL else any(found))


def overlap(bounds: Any) -> Callable[[Box], bool] | None:
    """What tells whether boxes in the world overlap with some bounds; None where there are none.

    Raises:
        RefusedError: bounds of a kind that is not known here, or that make no sense.
    """
    points = [(point.x, point.y, point.z) for point in bounds.points]
    if bounds.type == EMPTY:
        return None
    if bounds.type not in (BOX, SPHERE):
        raise RefusedError(UNSUPPORTED, f"bounds of type {bounds.type} filter nothing here; legal: box 1, sphere 3")
    if len(points) != 2 or not all(math.isfinite(number) for point in points for number in point):
        raise RefusedError(FAILED, "bounds are two points of finite numbers")
    one, other = points
    if bounds.type == BOX:
        return lambda box: all(
            low <= max(pair) and high >= min(pair)
            for low, high, pair in zip(box.low, box.high, zip(one, other, strict=True), strict=True)
        )
    radius = other[0]
    return lambda box: math.dist(one, _nearest(box, one)) <= radius


def _nearest(box: Box, point: Sequence[float]) -> list[float]:
    """The point of a box that is nearest to another."""
    return [min(max(value, low), high) for value, low, high in zip(point, box.low, box.high, strict=True)]
