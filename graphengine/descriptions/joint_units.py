"""Warns about position limits of joints that are probably swapped, or in degrees instead of radians."""

from __future__ import annotations

import math

from graphengine.descriptions.robot_description import TURNING, Joint
from graphengine.format.diagnostics import Findings

_MOST_TURNS = 2
"""Number of turns from zero up to which limits count as radians."""
_WHOLE_DEGREES = 5.0
_MOST_DEGREES = 720.0


def swapped_limits(joint: Joint, findings: Findings) -> bool:
    """Return whether the lower limit of a joint is above the upper limit; if so, add a warning."""
    limit, lower, upper = joint.bounds.element, joint.bounds.lower or 0.0, joint.bounds.upper or 0.0
    if limit is None or joint.type == "continuous" or lower <= upper:
        return False
    text = f"joint {joint.name!r}: the lower limit {lower:g} is above the upper limit {upper:g}: it moves freely"
    remedy = f'the limits are probably swapped: write lower="{upper:g}" upper="{lower:g}"'
    findings.add("W217", text, limit.place("lower"), remedy)
    return True


def check_degrees(joint: Joint, findings: Findings) -> None:
    """Add a warning if the limits of a revolute joint are multiples of 5 and one is more than two turns from zero, in rad."""
    limit, limits = joint.bounds.element, joint.limits
    if limit is None or limits is None or joint.type not in TURNING:
        return
    farthest = max(map(abs, limits))
    whole = all(value % _WHOLE_DEGREES == 0 for value in limits)
    if not (whole and _MOST_TURNS * math.tau < farthest <= _MOST_DEGREES):
        return
    text = f"joint {joint.name!r}: limits {limits[0]:g} to {limits[1]:g} rad reach {farthest / math.tau:.3g} turns from zero"
    low, high = (f"{math.radians(value):.6g}" for value in limits)
    findings.add("W217", text, limit.place("lower"), f'if they are in degrees, write lower="{low}" upper="{high}"')
