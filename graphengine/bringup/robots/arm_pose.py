"""Computes a pose near the start pose of an arm, for a first motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.robot_description import Joint, RobotDescription
from graphengine.physics.model.robot import RobotInstance

_TURN, _SLIDE = 0.3, 0.05
"""Distances of a rotating joint (rad) and of a sliding joint (m) from their start positions."""
_MARGIN = 0.05
"""Minimum distance of a joint from its limits, as a fraction of its range."""


def raised_pose(robot: RobotInstance, joints: Sequence[str]) -> dict[str, float]:
    """Return a dict from joints to positions (rad, m) near their starts and within their limits.

    Each joint moves in the direction that raises its links, away from a table.
    """
    axes = robot.description.axes_in_root()
    found: dict[str, float] = {}
    for name in joints:
        joint, start = robot.description.joints[name], robot.starts.get(name, 0.0)
        way = _SLIDE if joint.type == "prismatic" else _TURN
        way = way if _rise(robot.description, joint, axes[name]) >= 0 else -way
        low, high = _limits(joint)
        inside = [end for end in (start + way, start - way) if low <= end <= high]
        found[name] = round(inside[0] if inside else min(max(start, low), high), 3)
    return found


def _limits(joint: Joint) -> tuple[float, float]:
    """Return the limits of a joint reduced by a margin; infinite for a joint without limits."""
    low, high = joint.limits or (-np.inf, np.inf)
    margin = _MARGIN * (high - low) if np.isfinite(high - low) else 0.0
    return low + margin, high - margin


def _rise(description: RobotDescription, joint: Joint, axis: Sequence[float]) -> float:
    """Return the derivative of mass times height by the position of a joint, with all joints at zero: kg m/rad, or kg m/m."""
    origin = np.array(description.pose_in_root(joint.child)[0])
    rise = 0.0
    for link in description.depth_first(joint.child):
        place = np.array(description.pose_in_root(link.name)[0])
        motion = np.array(axis) if joint.type == "prismatic" else np.cross(axis, place - origin)
        rise += link.mass * float(motion[2])
    return round(rise, 6)
