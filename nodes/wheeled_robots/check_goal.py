"""The node that checks whether a base has reached a target pose."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import BadValueError, Bools, Double2, Double3, In, Out
from graphengine.nodes.wheeled_robots.planar import PlanarNode, wrapped


class CheckGoal2D(PlanarNode, type="isaacsim.robot.wheeled_robots.CheckGoal2D"):
    """Checks whether the position and the yaw of a base are within tolerances of a target."""

    target: Double3 = In(default=(0.0, 0.0, 0.0), unit="m, m, rad", doc="x, y and yaw of the target in the world frame")
    target_changed: bool = In(default=False, doc="no effect: every execution reads `target`")
    thresholds: Double2 = In(
        default=(0.1, 0.1), ge=0.0, unit="m, rad", doc="tolerances: [largest distance, largest yaw difference]"
    )
    reached_goal: Bools = Out(doc="[position reached, yaw reached]")

    def compute(self) -> None:
        """Compare the pose of the base with the target, and output which tolerances are met.

        Raises:
            BadValueError: the pose of the base is not finite, or the yaw of the target is infinite.
        """
        x, y, yaw = self.heading()
        if math.isinf(self.target[2]):
            raise BadValueError("target", self.target, "finite")
        distance = math.hypot(x - self.target[0], y - self.target[1])
        turn = abs(wrapped(yaw - self.target[2]))
        self.reached_goal = np.array((distance <= self.thresholds[0], turn <= self.thresholds[1]))
