"""Finds the command and sensor topics of a robot, and the graph inputs that contain its geometry and its speed limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graphengine.api.scene import Scene, loaded_of
from graphengine.bringup.calibration.figures import Twist
from graphengine.compiler.graph import Graph, Instance
from graphengine.format.errors import UsageError
from graphengine.format.wording import did_you_mean, listing, unknown
from graphengine.messages.endpoints import EndpointClaim
from graphengine.physics.model.robot import RobotInstance

TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
ACKERMANN = "ackermann_msgs/msg/AckermannDriveStamped"
COMMAND_TYPES = (TWIST, TWIST_STAMPED, ACKERMANN)
ODOMETRY, IMU = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu"


@dataclass(frozen=True, slots=True)
class CommandTopic:
    """A topic to which a robot's graphs subscribe for velocity commands."""

    topic: str
    type: str

    def message(self, twist: Twist, time: float, wheel_base: float | None) -> dict[str, Any]:
        """Return the fields of a command message.

        Args:
            twist: velocity to command; AckermannDriveStamped has no sideways velocity.
            time: simulation time for the stamp, s.
            wheel_base: distance between the axles, m, which converts a turn rate to a steering angle.
        """
        seconds, fraction = divmod(time, 1.0)
        header = {"stamp": {"sec": int(seconds), "nanosec": int(fraction * 1e9)}}
        if self.type == ACKERMANN:
            slope = wheel_base * twist.yaw / twist.x if wheel_base and twist.x else 0.0
            return {"header": header, "drive": {"speed": twist.x, "steering_angle": math.atan(slope)}}
        velocity = {"linear": {"x": twist.x, "y": twist.y}, "angular": {"z": twist.yaw}}
        return velocity if self.type == TWIST else {"header": header, "twist": velocity}


def find_robots(scene: Scene, names: Sequence[str], purpose: str) -> list[RobotInstance]:
    """Return the robots of a scene with these names; without names, all robots.

    Args:
        scene: the scene.
        names: names of robots; empty takes all robots.
        purpose: verb for the message about a scene without robots, such as `calibrate`.

    Raises:
        UsageError: the scene has no robot, or no robot has one of the names.
    """
    world = loaded_of(scene).world
    robots = world.robots if world is not None else {}
    if not robots:
        raise UsageError(f"{loaded_of(scene).path}: there is no robot to {purpose}; give a scene with a robot")
    for name in names:
        if name not in robots:
            raise UsageError(unknown("robot", name, robots))
    return [robots[name] for name in names or robots]


def find_command(claims: Sequence[EndpointClaim], wanted: str | None) -> CommandTopic | None:
    """Return the command topic of the robot; None if no graph subscribes to a topic of a command type.

    Args:
        claims: topics of the robot's graphs.
        wanted: full name of the topic, or unique last parts of the name; None chooses the only command topic.

    Raises:
        UsageError: several topics command the robot and `wanted` is None, or `wanted` matches no topic or several topics.
    """
    found = {claim.topic: claim.message_type for claim in claims_of(claims, "subscribe", *COMMAND_TYPES)}
    if wanted is not None:
        end = f"/{wanted.lstrip('/')}"
        meant = [wanted] if wanted in found else [topic for topic in found if topic.endswith(end)]
        if len(meant) != 1:
            near = did_you_mean(wanted, found) or listing(meant or found, "command topics")
            raise UsageError(f"--command-topic {wanted}: expected the name of one command topic\n  {near}")
        return CommandTopic(meant[0], found[meant[0]])
    if len(found) > 1:
        topics = listing(found, "command topics")
        raise UsageError(f"several topics command the robot; choose one with --command-topic\n  {topics}")
    return next((CommandTopic(*one) for one in found.items()), None)


def published(claims: Sequence[EndpointClaim], message_type: str) -> list[str]:
    """Return the topics of a type that the robot's graphs publish, sorted by name."""
    return sorted({claim.topic for claim in claims_of(claims, "publish", message_type)})


def claims_of(claims: Iterable[EndpointClaim], direction: str, *message_types: str) -> list[EndpointClaim]:
    """Return the endpoints with a direction, such as `publish`, and one of the message types."""
    return [claim for claim in claims if claim.direction == direction and claim.message_type in message_types]


def inputs_named(graphs: Iterable[Graph], *names: str) -> Iterator[tuple[Graph, Instance, str, Any]]:
    """Yield each unwired input with one of these names, as (graph, node instance, name of the input, value).

    Inputs whose value is neither a number nor an array of numbers are left out.
    """
    for graph in graphs:
        wired = graph.wired_ports
        for instance in graph.instances:
            for port in instance.cls.fields.values():
                if port.side != "inputs" or port.name not in names or (instance.id, port.name) in wired:
                    continue
                value = instance.value(port.field)
                is_number = isinstance(value, int | float) and not isinstance(value, bool)
                if is_number or (isinstance(value, np.ndarray) and value.ndim == 1):
                    yield graph, instance, port.name, value


def limit_of(scene: Scene, *names: str) -> float:
    """Return the lowest nonzero magnitude of all inputs with these names, because 0 stands for no limit; else infinity."""
    return min((number for *_, number in numbers_named(loaded_of(scene).planned, *names)), default=math.inf)


def known_wheel_base(scene: Scene) -> float | None:
    """Return the magnitude of the first nonzero input `wheelBase` in the graphs, m; None without such an input."""
    return next((number for *_, number in numbers_named(loaded_of(scene).planned, "wheelBase")), None)


def numbers_named(graphs: Iterable[Graph], *names: str) -> Iterator[tuple[Graph, Instance, str, float]]:
    """Yield each nonzero number in the inputs of `inputs_named` as (graph, node instance, name of the input, magnitude)."""
    for graph, instance, name, value in inputs_named(graphs, *names):
        yield from ((graph, instance, name, abs(float(one))) for one in np.atleast_1d(value) if one)
