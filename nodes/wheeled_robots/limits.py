"""Limits of speeds and accelerations for controllers; 0 is no limit."""

from __future__ import annotations


def limited(value: float, limit: float) -> float:
    """Return the value clamped to the range from -`limit` to `limit`; a limit of 0 is no limit."""
    return value if limit == 0.0 else min(max(value, -limit), limit)


def ramped(before: float, target: float, rate: float, dt: float) -> float:
    """Return `before` moved towards `target` by at most `rate * dt`; a rate of 0 is no limit."""
    return before + limited(target - before, rate * dt) if rate else target
