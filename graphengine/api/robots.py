"""Robots of a session: their poses, joints and topics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from graphengine.api.bodies import Body
from graphengine.api.guards import acting, reading
from graphengine.api.runner import Runner
from graphengine.api.sensors import RobotSensor, find_sensors
from graphengine.api.topics import M, MessageType, Publication, Subscription, open_subscription
from graphengine.api.values import plain
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Prim
from graphengine.format.errors import GraphError, UnknownEntityError, UsageError
from graphengine.format.wording import listing, unknown
from graphengine.messages.names import full_topic, join_namespaces

Targets = Mapping[str, float] | Sequence[float] | NDArray[np.float64]
"""Targets of joints: a mapping by joint name, or numbers in the order of the argument `joints`."""


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


class Robot(Body):
    """A robot of a session; each property returns its value in the current tick. `Session.robots` has all robots by name.

    Its pose and velocity are those of the base link.

    Attributes:
        name: name of the robot in the scene.
    """

    @property
    @reading
    def joints(self) -> Mapping[str, Joint]:
        """States of the movable joints by joint name, in the order of the articulation."""
        joints = self._runner.session.services.world.articulation(find_robot(self._runner, self.name))
        values = (joints.positions().tolist(), joints.velocities().tolist(), joints.efforts().tolist())
        return {name: Joint(*state) for name, *state in zip(joints.joint_names, *values, strict=True)}

    @property
    @reading
    def sensors(self) -> Mapping[str, RobotSensor]:
        """Sensors by their names in the robot file. Each device of a sensor that has several is named with the path of its prim.

        >>> list(sim.robots["dd100"].sensors)[:2]
        ['sim_lidar', 'sim_camera/RSD455/Camera_OmniVision_OV9782_Color']
        """
        return find_sensors(self._runner, find_robot(self._runner, self.name))

    @property
    @reading
    def namespace(self) -> str:
        """Namespace of the robot's topics, without a leading slash, such as `dd100_0000`; empty if there is no namespace."""
        base_link = find_robot(self._runner, self.name).facts["base_link"]
        return join_namespaces(self._runner.session.services.stage.namespaces(base_link))

    @acting
    def command(
        self,
        positions: Targets | None = None,
        velocities: Targets | None = None,
        efforts: Targets | None = None,
        *,
        joints: Sequence[str] | None = None,
    ) -> None:
        """Set targets of joints, which hold until the next command to the same joint. A recording stores the call.

        The targets act from the physics steps of the next tick on, which run before its graphs. A graph that commands the same
        joint in that tick wins: its target replaces this one from the following tick on. Where a graph commands the joint in
        every tick, as `cmd_vel` of the dd100 does, call `command` before every tick, or use a robot file without that graph.
        `reset` sets the initial targets again. Targets beyond the limits of a joint are clamped and counted, as those of
        IsaacArticulationController.

        >>> robot = sim.robots["dd100"]
        >>> for _ in range(10):
        ...     robot.command(velocities={"front_left_wheel_joint": 5.0, "front_right_wheel_joint": 5.0})
        ...     sim.step()
        >>> round(robot.joints["front_left_wheel_joint"].velocity, 1)
        5.0
        >>> robot.command(velocities=[0.0, 0.0], joints=["front_left_wheel_joint", "front_right_wheel_joint"])

        Args:
            positions: position targets, rad, or m for a prismatic joint; the joint needs a drive with stiffness. A mapping from
                joint names to numbers, or numbers in the order of `joints`. NaN keeps the target of its joint.
            velocities: velocity targets in the same form, rad/s or m/s; the joint needs a drive with damping.
            efforts: torques or forces in the same form, N m or N, which act in addition to those of drives.
            joints: joint names for targets that are not mappings; None is all joints, in the order of `Robot.joints`.

        Raises:
            UnknownEntityError: the robot was removed.
            UsageError: the robot has no such joint, the joint has no drive for this kind of target, there is not one number for
                each joint, or a number is infinite. No target has changed.
        """
        given = {"positions": positions, "velocities": velocities, "efforts": efforts}
        named = {kind: self._by_joint(kind, it, joints) for kind, it in given.items() if it is not None}
        self._runner.command("command", robot=self.name, **named)

    @acting
    def reset(
        self,
        joints: Mapping[str, float] | None = None,
        position: Vector3 | None = None,
        orientation: Quaternion | None = None,
        keyframe: str | None = None,
        *,
        force: bool = False,
    ) -> None:
        """Return this robot to its initial state, or to another pose, between two ticks. A recording stores the call.

        All velocities become zero, the initial joint targets apply again, the robot's sensors are reset, pushes end, and grippers
        open. Time, graphs and other robots continue; ground-truth odometry continues as after `Session.move`.

        >>> robot = sim.robots["dd100"]
        >>> robot.reset(joints={"front_left_wheel_joint": 0.5}, position=(1.0, 0.0, 0.025))
        >>> robot.pose.position, robot.joints["front_left_wheel_joint"].position
        ((1.0, 0.0, 0.025), 0.5)

        Args:
            joints: positions of joints by name, rad or m; mimic joints follow. Drives with stiffness get these positions as
                targets. Other joints return to their initial positions.
            position: position of the base link in the world frame, m; None is the initial position.
            orientation: quaternion (x, y, z, w) in the world frame; None is the initial orientation.
            keyframe: name of a keyframe in the robot's MJCF, in place of the initial state; the other arguments override it.
            force: whether to place the robot even if it overlaps others; this logs a warning, and physics pushes them apart.

        Raises:
            BlockedPoseError: the robot would overlap others by 5 mm or more at this position or orientation.
            UnknownEntityError: the robot was removed.
            UsageError: the robot has no such joint or keyframe, a position is beyond the limits of its joint, or the robot cannot
                be placed. Nothing has changed.
        """
        turned = {"quaternion_xyzw": orientation} if orientation is not None else None
        given = {
            "joints": joints or {},
            "position": position,
            "orientation": turned,
            "keyframe": keyframe,
            "force": force,
        }
        self._runner.command("reset-robot", robot=self.name, **plain(given))

    def _by_joint(self, kind: str, targets: Targets, joints: Sequence[str] | None) -> dict[str, Any]:
        """Return targets by joint name, as JSON types and without NaN."""
        values = plain(targets)
        if not isinstance(targets, Mapping):
            robot = find_robot(self._runner, self.name)
            names = self._runner.session.services.world.articulation(robot).joint_names if joints is None else joints
            if len(values) != len(names) or len(set(names)) != len(names):
                text = f"{kind}: expected one number for each of {len(names)} different joints, got {len(values)}"
                raise UsageError(f"{text}\n  {listing(names, 'joints')}")
            values = dict(zip(names, values, strict=True))
        elif joints is not None:
            raise UsageError(f"{kind}: the mapping names its joints; leave out the argument `joints`")
        return {name: value for name, value in values.items() if value == value}

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
    prims = runner.session.services.stage.robots()
    if name not in prims:
        raise UnknownEntityError(f"no robot {name!r}: it was removed\n  {listing(prims, 'robots')}")
    return prims[name]
