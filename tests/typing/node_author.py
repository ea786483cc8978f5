# mypy: ignore-errors
"""What authors and users of nodes get wrong, and what mypy and pyright tell them; the first line is left out when they look.

Where an error is to be told, the line ends in a comment: mypy's code, then pyright's rule. Every other line must be clean.
"""

from __future__ import annotations

import math

from graphengine.node import (
    Bound,
    Clock,
    Context,
    Doubles,
    ExecIn,
    ExecOut,
    Fire,
    In,
    Node,
    Out,
    State,
    Token,
    Vector3d,
    node,
)
from graphengine.nodes.ros2.imu import ROS2PublishImu
from graphengine.nodes.ros2.state import ROS2PublishOdometry


class Gain(Node, type="typing.Gain", gated=True):
    """Multiplies a speed."""

    exec_in = ExecIn()
    factor: float = In(doc="without a default: the constructor demands it")
    speed: float = In(default=0.0, unit="m/s")
    mode: Token = In(default="plain", tokens=("plain", "double"))
    scaled: float = Out(unit="m/s")
    history: Doubles = Out()
    rounds: int = State(default=0)
    clock: Clock = Bound()
    exec_out = ExecOut()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock
        self.clock = context  # error: assignment reportAttributeAccessIssue

    def compute(self) -> Fire:
        """Multiply."""
        self.scaled = self.factor * self.speed
        self.scaled = "fast"  # error: assignment reportAttributeAccessIssue
        self.rounds += 1
        self.scaled = self.speeed  # error: attr-defined reportAttributeAccessIssue
        self.scalled = 1.0  # a new attribute to both; `__slots__` refuses it when it runs, and check_node finds it
        if self.exec_in > 1:
            return self.exec_out | "more"  # error: operator reportOperatorIssue
        return self.exec_out


class Place(Node, type="typing.Place"):
    """Holds a place."""

    position: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m")
    place: Vector3d = In(default=(0.0, 0.0))  # error: assignment reportAssignmentType
    distance: float = In(default="far")  # error: assignment reportAssignmentType


@node("typing.Hypotenuse")
def hypotenuse(a: float, b: float = 1.0) -> float:
    """Longest side of a right-angled triangle."""
    return math.hypot(a, b)


right = Gain(factor=2.0, speed=1.0, mode="double")
right.speed = 2.0
right.compute()
result: float = right.scaled
count: int = right.exec_in
place = Place(position=(1.0, 2.0, 3.0))
ROS2PublishOdometry(position=(1.0, 0.0, 0.0)).pose_covariance.sum()  # an input of an array may have a default too
ROS2PublishImu(linear_acceleration=(0.0, 0.0, 9.81)).orientation_covariance.sum()

Gain(speed=1.0)  # error: call-arg reportCallIssue
Gain(factor=2.0, sped=1.0)  # error: call-arg reportCallIssue
Gain(factor="two")  # error: arg-type reportArgumentType
Gain(2.0)  # error: call-arg reportCallIssue
Gain(factor=2.0, scaled=3.0)  # error: call-arg reportCallIssue
Gain(factor=2.0, rounds=3)  # error: call-arg reportCallIssue
Gain(factor=2.0, exec_in=1)  # error: call-arg reportCallIssue
Place(position=(1.0, 2.0))  # error: arg-type reportArgumentType
misspelt: float = right.scald  # error: attr-defined reportAttributeAccessIssue
right.speed = "fast"  # error: assignment reportAttributeAccessIssue
wrong: str = right.scaled  # error: assignment reportAssignmentType
