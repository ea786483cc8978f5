"""Actions of an environment: velocities of a base, and targets of joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from graphengine.api.gym.observations import Limit, spread
from graphengine.api.robots import find_robot
from graphengine.api.session import Session
from graphengine.format.errors import UsageError


@dataclass(frozen=True)
class Actuation:
    """An action in a session: what each number commands, the limits of the numbers, and a function that sends them."""

    names: Sequence[str]
    limits: Sequence[NDArray[np.float64]]
    send: Callable[[NDArray[np.float64]], object]


@dataclass(frozen=True)
class BaseVelocity:
    """Speeds of a mobile base, which each step sends as one `Twist` or `TwistStamped`.

    A graph may stop the robot if no message arrives for some time, such as 0.5 s; a step must be shorter.

    Attributes:
        topic: full name of the topic, such as `/dd100_0000/cmd_vel`.
        linear: greatest speed forwards and backwards, m/s; None is the input `maxLinearSpeed` of the graph that reads the topic.
        angular: greatest turn rate, rad/s; None is the input `maxAngularSpeed` of this graph.
        lateral: greatest speed sideways, m/s; with 0, the action has two numbers, otherwise three.
    """

    topic: str
    linear: float | None = None
    angular: float | None = None
    lateral: float = 0.0

    def _open(self, sim: Session) -> Actuation:
        """Return the action in a session.

        Raises:
            MessageError: the topic has another message type.
            UsageError: no graph reads the topic, or a speed has no limit.
        """
        claims = sim._runner.session.services.claims
        readers = [claim for claim in claims if claim.topic == self.topic and claim.direction == "subscribe"]
        stamped = any(claim.message_type.endswith("/TwistStamped") for claim in readers)

        def send(speeds: NDArray[np.float64]) -> None:
            x, *y, turn = speeds.tolist()
            twist = {"linear": {"x": x, "y": sum(y, 0.0)}, "angular": {"z": turn}}
            sim.publish(self.topic, {"twist": twist} if stamped else twist)

        send(np.zeros(2))  # raises an error for a wrong topic
        graphs = tuple(f"{claim.graph}/" for claim in readers)
        names, high = ["x, m/s", "turn rate, rad/s"], [self._limit(sim, graphs, name) for name in ("linear", "angular")]
        if self.lateral:
            names.insert(1, "y, m/s")
            high.insert(1, self.lateral)
        return Actuation(names, spread(self.topic, [np.negative(high)], [high], [len(high)]), send)

    def _limit(self, sim: Session, graphs: tuple[str, ...], name: str) -> float:
        """Return the given limit of a speed, or the least input of some graphs; an input of 0 is no limit."""
        given, port = getattr(self, name), f".max{name.title()}Speed"
        ports = sim.values("*").items()
        found = [value for address, value in ports if address.startswith(graphs) and address.endswith(port) and value]
        if given is None and not found:
            raise UsageError(f"{self.topic}: no graph that reads it has an input {port[1:]}\n  give {name}=")
        return float(min(found) if given is None else given)


@dataclass(frozen=True)
class JointTargets:
    """Targets of joints, as in `Robot.command`.

    Attributes:
        robot: name of the robot.
        quantity: `positions` (rad, m), `velocities` (rad/s, m/s) or `efforts` (N m, N).
        joints: names of the joints; None is all joints, in the order of `Robot.joints`.
        low: least target, or one for each joint; None is the limit in the robot's description, which has none for efforts.
        high: greatest target, or one for each joint; None is as for `low`.
    """

    robot: str
    quantity: Literal["positions", "velocities", "efforts"]
    joints: Sequence[str] | None = None
    low: Limit = None
    high: Limit = None

    def _open(self, sim: Session) -> Actuation:
        """Return the action in a session.

        Raises:
            UsageError: the session has no such robot or joint, or the targets of a joint have no limits.
        """
        robot = sim.robots[self.robot]
        joints = sim._runner.session.services.world.articulation(find_robot(sim._runner, self.robot))
        names = joints.joint_names if self.joints is None else self.joints

        def send(targets: NDArray[np.float64]) -> None:
            arguments: dict[str, Any] = {self.quantity: targets}
            robot.command(**arguments, joints=names)

        send(np.zeros(len(names)))  # raises an error for wrong joints
        spans = {"positions": joints.ranges, "velocities": [(-most, most) for most in joints.max_velocities]}
        known = dict(zip(joints.joint_names, spans.get(self.quantity, ()), strict=False))
        low, high = np.transpose([known.get(name, (-math.inf, math.inf)) for name in names])
        limits = spread(f"{self.quantity} of {self.robot}", (self.low, low), (self.high, high), low.shape)
        for name, *span in zip(names, *limits, strict=True):
            if math.inf in np.abs(span):
                raise UsageError(f"{self.robot}: joint {name} has no limits of {self.quantity}\n  give low= and high=")
        return Actuation(names, limits, send)
