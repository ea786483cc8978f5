"""Robots of a session: their poses, joints and topics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, overload

from graphengine.api.guards import acting, reading
from graphengine.api.runner import Runner
from graphengine.api.topics import M, MessageType, Publication, Subscription, open_subscription
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Prim
from graphengine.format.errors import GraphError, UnknownEntityError
from graphengine.format.wording import listing, unknown
from graphengine.messages.names import full_topic, join_namespaces


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and orientation of a body.

    Attributes:
        position: position in the world frame, m.
        orientation: orientation in the world frame as a quaternion (x, y, z, w).
    """

    position: Vector3
    orientation: Quaternion


@dataclass(frozen=True, slots=True)
class Velocity:
    """Linear and angular velocity of a body.

    Attributes:
        linear: velocity of the body's origin in the world frame, m/s.
        angular: angular velocity in the world frame, rad/s.
    """

    linear: Vector3
    angular: Vector3


@dataclass(frozen=True, slots=True)
class Joint:
    """The state of a joint.

    Attributes:
        position: position, rad, or m for a prismatic joint.
        velocity: velocity, rad/s or m/s.
        effort: torque or force of the joint's drive after the last step, N m or N.
    """

    position: float
    velocity: float
    effort: float


class Robot:
    """A robot of a session; each property returns its value in the current tick. `Session.robots` has all robots by name.

    Attributes:
        name: name of the robot in the scene.
    """

    def __init__(self, runner: Runner, name: str) -> None:
        self._runner = runner
        self.name = name

    @property
    @reading
    def pose(self) -> Pose:
        """Pose of the base link in the world frame: position in m, orientation as a quaternion (x, y, z, w)."""
        state = self._runner.session.services.world.entities.state(self.name)
        return Pose(state.position, state.orientation)

    @property
    @reading
    def velocity(self) -> Velocity:
        """Velocity of the base link in the world frame, m/s and rad/s."""
        state = self._runner.session.services.world.entities.state(self.name)
        return Velocity(state.linear_velocity, state.angular_velocity)

    @property
    @reading
    def joints(self) -> Mapping[str, Joint]:
        """States of the movable joints by joint name, in the order of the articulation."""
        joints = self._runner.session.services.world.articulation(find_robot(self._runner, self.name))
        values = (joints.positions().tolist(), joints.velocities().tolist(), joints.efforts().tolist())
        return {name: Joint(*state) for name, *state in zip(joints.joint_names, *values, strict=True)}

    @property
    @reading
    def namespace(self) -> str:
        """Namespace of the robot's topics, without a leading slash, such as `dd100_0000`; empty if there is no namespace."""
        base_link = find_robot(self._runner, self.name).facts["base_link"]
        return join_namespaces(self._runner.session.services.stage.namespaces(base_link))

    @acting
    def publish(self, topic: str, message: Any, every: float | None = None, type: MessageType = None) -> Publication:
        """Publish a message on a topic in the robot's namespace. The arguments are those of `Session.publish`.

        A name that begins with a slash is absolute, as in ROS.

        >>> drive = sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.2}})
        """
        return Publication(self._runner, self._full(topic), message, every, type)

    @overload
    def subscribe(self, topic: str, type: type[M], keep: int = 1000) -> Subscription[M]: ...
    @overload
    def subscribe(self, topic: str, type: str | None = None, keep: int = 1000) -> Subscription[Any]: ...
    def subscribe(self, topic: str, type: MessageType = None, keep: int = 1000) -> Subscription[Any]:
        """Subscribe to a topic in the robot's namespace. The arguments are those of `Session.subscribe`.

        A name that begins with a slash is absolute, as in ROS.

        >>> odom = sim.robots["dd100"].subscribe("odom")
        """
        return open_subscription(self, self._full(topic), type, keep)

    def _full(self, topic: str) -> str:
        return topic if topic.startswith("/") else full_topic(self.namespace, topic)

    def __repr__(self) -> str:
        try:
            x, y, z = self.pose.position
        except GraphError:  # the robot is removed, or the session closed
            return f"<Robot {self.name}>"
        return f"<Robot {self.name} at ({x:.3f}, {y:.3f}, {z:.3f}) m>"


class Robots(dict[str, Robot]):
    """Robots by name; an unknown name raises UnknownEntityError."""

    def __missing__(self, name: str) -> Robot:
        """Raise UnknownEntityError; its message suggests similar names, or lists all names."""
        raise UnknownEntityError(unknown("robot", name, self))


def find_robot(runner: Runner, name: str) -> Prim:
    """Return the prim of the robot with this name.

    Raises:
        UnknownEntityError: no robot has the name.
    """
    prims = {prim.entity_name: prim for prim in runner.session.services.stage.prims("robot")}
    if name not in prims:
        raise UnknownEntityError(f"no robot {name!r}: it was removed\n  {listing(prims, 'robots')}")
    return prims[name]
