"""Comparison of a base's pose with its target."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import BadValueError, Bools, Double2, Double3, In, Out
from graphengine.nodes.wheeled_robots.planar import PlanarNode, wrapped


class CheckGoal2D(PlanarNode, type="isaacsim.robot.wheeled_robots.CheckGoal2D"):
    """Checks whether a base is within a distance of a target, and within an angle of the target's yaw."""

    target: Double3 = In(default=(0.0, 0.0, 0.0), unit="m, m, rad", doc="x, y and yaw in the world frame")
    target_changed: bool = In(default=False, doc="no effect: the target is always read")
    thresholds: Double2 = In(default=(0.1, 0.1), unit="m, rad", doc="tolerances of position and yaw")
    reached_goal: Bools = Out(doc="[position reached, yaw reached]")

    def compute(self) -> None:
        """Compare pose and target.

        Raises:
            BadValueError: the base's pose, or the target's yaw, is not finite.
        """
        x, y, yaw = self.heading()
        if math.isinf(self.target[2]):
            raise BadValueError("target", self.target, "finite")
        distance = math.hypot(x - self.target[0], y - self.target[1])
        turn = abs(wrapped(yaw - self.target[2]))
        self.reached_goal = np.array((distance <= self.thresholds[0], turn <= self.thresholds[1]))
