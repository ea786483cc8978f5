"""Limits of speed and of its change, as the controllers have them; 0 is no limit."""

from __future__ import annotations


def limited(value: float, limit: float) -> float:
    """Within plus and minus the limit; 0 is no limit."""
    return value if limit == 0.0 else min(max(value, -limit), limit)


def ramped(before: float, target: float, rate: float, dt: float) -> float:
    """The target, or as near to it as `rate` lets a value come in `dt` seconds; 0 is no limit."""
    return before + limited(target - before, rate * dt) if rate else target
