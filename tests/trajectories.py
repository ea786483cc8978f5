"""Messages of trajectories for tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.nodes.ros2.robot_action import duration, message

FOLLOW = "control_msgs/action/FollowJointTrajectory"


def point(
    time: float,
    positions: ArrayLike = (),
    velocities: ArrayLike = (),
    accelerations: ArrayLike = (),
    effort: ArrayLike = (),
) -> Any:
    """A point at a time after the start, s."""
    states = (np.array(state, float) for state in (positions, velocities, accelerations, effort))
    return message("trajectory_msgs/msg/JointTrajectoryPoint", *states, duration(time))


def trajectory(names: Sequence[str], *points: Any, stamp: float = 0.0) -> Any:
    """A trajectory of these joints."""
    header = messages.Header(messages.stamp(stamp), "")
    return message("trajectory_msgs/msg/JointTrajectory", header, list(names), list(points))


def tolerance(name: str, position: float = 0.0, velocity: float = 0.0) -> Any:
    """A tolerance of one joint; 0 keeps the default, -1 removes it."""
    return message("control_msgs/msg/JointTolerance", name, position, velocity, 0.0)


def goal(message: Any, **fields: Any) -> Any:
    """A goal with a trajectory and other fields."""
    made = DEFINITIONS.initial(f"{FOLLOW}_Goal")
    made.trajectory = message
    for name, value in fields.items():
        setattr(made, name, value)
    return made
