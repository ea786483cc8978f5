"""The filters of EntityFilters messages: name, tags and bounds of entities."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Sequence
from typing import Any

from graphengine.control.simulation_interfaces.results import FAILED, UNSUPPORTED, RefusedError
from graphengine.devices.entity import Box

MAX_PATTERN = 1000
"""Maximum length of a filter of entities, characters."""
MAX_UNROLLED = 100_000
"""Maximum length of a regular expression after `regex` has expanded repetitions such as `{3}`, characters."""
PATIENCE = 0.1
"""Maximum time to match all names, s; without this limit, some expressions would take years."""
EMPTY, BOX, CONVEX_HULL, SPHERE = range(4)
_ALL = 1
"""Value of `TagsFilter.FILTER_MODE_ALL`."""


def name_filter(pattern: str, names: Sequence[str]) -> list[str]:
    """Return the names in which a regular expression finds a match; POSIX character classes are supported.

    Raises:
        RefusedError: the pattern is not a regular expression, is too long, or takes too long.
    """
    if not pattern:
        return list(names)
    if len(pattern) > MAX_PATTERN:
        raise RefusedError(FAILED, f"a filter has at most {MAX_PATTERN} characters")
    if len(pattern) * _repetitions(pattern) > MAX_UNROLLED:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} has too many repetitions")
    import regex  # a match with Python's `re` cannot be stopped

    try:
        expression, deadline = regex.compile(pattern), time.monotonic() + PATIENCE
        return [name for name in names if expression.search(name, timeout=max(deadline - time.monotonic(), 0.0))]
    except (regex.error, OverflowError, RecursionError) as error:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} is not a regular expression: {error}") from None
    except TimeoutError:
        raise RefusedError(FAILED, f"the filter {pattern[:80]!r} takes too long") from None


def _repetitions(pattern: str) -> int:
    """Return an upper bound of the factor by which the expansion of repetitions such as `{3}` lengthens a pattern."""
    counts = (re.findall(r"[0-9]+", braces) for braces in re.findall(r"\{[^{}]*\}", pattern))
    return math.prod(max(*map(int, found), 1) for found in counts if found)


def has_tags(wanted: Any, tags: Sequence[str]) -> bool:
    """Return whether the tags of an entity match a TagsFilter message; an empty filter matches all tags."""
    found = [tag in tags for tag in wanted.tags]
    return not found or (all(found) if wanted.filter_mode == _ALL else any(found))


def overlap(bounds: Any) -> Callable[[Box], bool] | None:
    """Return a function that returns whether a box in the world overlaps the given bounds; None for empty bounds.

    Raises:
        RefusedError: the bounds have an unsupported type, or are invalid.
    """
    points = [(point.x, point.y, point.z) for point in bounds.points]
    if bounds.type == EMPTY:
        return None
    if bounds.type not in (BOX, SPHERE):
        raise RefusedError(UNSUPPORTED, f"unsupported bounds of type {bounds.type}; legal: 1 (box), 3 (sphere)")
    if len(points) != 2 or not all(math.isfinite(number) for point in points for number in point):
        raise RefusedError(FAILED, "bounds must have two points with finite coordinates")
    one, other = points
    if bounds.type == BOX:
        return lambda box: all(
            low <= max(pair) and high >= min(pair)
            for low, high, pair in zip(box.low, box.high, zip(one, other, strict=True), strict=True)
        )
    radius = other[0]
    return lambda box: math.dist(one, _nearest(box, one)) <= radius


def _nearest(box: Box, point: Sequence[float]) -> list[float]:
    """Return the point of a box that is nearest to a given point."""
    return [min(max(value, low), high) for value, low, high in zip(point, box.low, box.high, strict=True)]
