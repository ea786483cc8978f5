"""Functions that limit speeds and accelerations, for controllers; a limit of 0 means no limit."""

from __future__ import annotations


def limited(value: float, limit: float) -> float:
    """Return the value clamped to the range from -`limit` to `limit`; a limit of 0 means no limit."""
    return value if limit == 0.0 else min(max(value, -limit), limit)


def ramped(before: float, target: float, rate: float, dt: float) -> float:
    """Return `before` moved towards `target` by at most `rate * dt`; return `target` if the rate is 0."""
    return before + limited(target - before, rate * dt) if rate else target
