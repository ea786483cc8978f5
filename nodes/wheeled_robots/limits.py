"""Limits of speeds and accelerations for controllers; 0 is no limit."""

from __future__ import annotations


def limited(value: float, limit: float) -> float:
    """The value clamped to plus and minus the limit; 0 is no limit."""
    return value if limit == 0.0 else min(max(value, -limit), limit)


def ramped(before: float, target: float, rate: float, dt: float) -> float:
    """The value after moving from `before` towards the target by at most `rate * dt`; a rate of 0 is no limit."""
    return before + limited(target - before, rate * dt) if rate else target
