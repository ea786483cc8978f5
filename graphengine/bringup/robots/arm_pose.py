"""Computes a pose near the start pose of an arm, for a first motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.robot_description import Joint, RobotDescription
from graphengine.physics.model.robot import RobotInstance

_TURN, _SLIDE = 0.3, 0.05
"""Distances that a rotating joint (rad) and a sliding joint (m) move from the start position."""
_MARGIN = 0.05
"""Minimum distance of a joint from its limits, as a fraction of its range."""


def raised_pose(robot: RobotInstance, joints: Sequence[str]) -> dict[str, float]:
    """Return a position (rad, m) for each joint, a little away from its start and within its limits.

    Each joint moves in the direction that raises the links it carries, away from a table.
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
    """Return the limits of a joint, which are those of the robot file if it has any, reduced by a margin."""
    low, high = joint.limits or (-np.inf, np.inf)
    margin = _MARGIN * (high - low) if np.isfinite(high - low) else 0.0
    return low + margin, high - margin


def _rise(description: RobotDescription, joint: Joint, axis: Sequence[float]) -> float:
    """Return the rate at which a joint lifts the mass that it carries, with all joints at zero: kg m/rad, or kg m/m."""
    origin = np.array(description.pose_in_root(joint.child)[0])
    rise = 0.0
    for link in description.depth_first(joint.child):
        place = np.array(description.pose_in_root(link.name)[0])
        motion = np.array(axis) if joint.type == "prismatic" else np.cross(axis, place - origin)
        rise += link.mass * float(motion[2])
    return round(rise, 6)
