"""Comparison of the pose of a base with its target."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import BadValueError, Bools, Double2, Double3, In, Out
from graphengine.nodes.wheeled_robots.planar import PlanarNode, wrapped


class CheckGoal2D(PlanarNode, type="isaacsim.robot.wheeled_robots.CheckGoal2D"):
    """Checks whether a base has reached a target: its position and its yaw, each within a tolerance."""

    target: Double3 = In(default=(0.0, 0.0, 0.0), unit="m, m, rad", doc="x, y and yaw to reach, in the world frame")
    target_changed: bool = In(default=False, doc="no effect: every execution reads `target`")
    thresholds: Double2 = In(
        default=(0.1, 0.1), unit="m, rad", doc="largest distance and largest yaw difference that count as reached"
    )
    reached_goal: Bools = Out(doc="[position reached, yaw reached]")

    def compute(self) -> None:
        """Compare pose and target.

        Raises:
            BadValueError: the pose of the base is not finite, or the yaw of the target is infinite.
        """
        x, y, yaw = self.heading()
        if math.isinf(self.target[2]):
            raise BadValueError("target", self.target, "finite")
        distance = math.hypot(x - self.target[0], y - self.target[1])
        turn = abs(wrapped(yaw - self.target[2]))
        self.reached_goal = np.array((distance <= self.thresholds[0], turn <= self.thresholds[1]))
