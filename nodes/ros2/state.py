"""Nodes that publish the simulation time, and the joint states and odometry of a robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.compiler.lint_registry import lint
from graphengine.devices.motion import Articulation
from graphengine.format.errors import BadValueError, GraphError
from graphengine.messages import messages
from graphengine.node import Bound, Context, In
from graphengine.node.types import Doubles, Float, Quaterniond, String, Target, Tokens, UChars, Vector3d, read_only
from graphengine.nodes.checked import same_length
from graphengine.nodes.core.articulation import NO_JOINTS
from graphengine.nodes.known_inputs import known_inputs
from graphengine.nodes.ros2.publisher import PublisherNode, header, stamp

if TYPE_CHECKING:
    from graphengine.compiler.lint_registry import LintContext


class ROS2PublishClock(PublisherNode, type="isaacsim.ros2.bridge.ROS2PublishClock"):
    """Publishes simulation time as rosgraph_msgs/Clock.

    When the time jumps, for example by a reset, the new time is published on the topic `/clock` at once, even while the session
    is paused: tf2 buffers then discard transforms from the future.
    """

    message_type: ClassVar[str] = "rosgraph_msgs/msg/Clock"

    topic_name: String = In(default="clock", setup=True)

    def message(self) -> messages.Clock:
        """Return the message with the time `timeStamp`."""
        return messages.Clock(stamp(self.time_stamp))

    def announce_time(self) -> None:
        """Publish the time after a jump, if the topic is `/clock`, from which ROS nodes take simulation time."""
        if self.publisher.topic == "/clock":
            self.compute()


_PRISMATIC = 1


class ROS2PublishJointState(PublisherNode, type="isaacsim.ros2.bridge.ROS2PublishJointState"):
    """Publishes joint states from arrays, or the joint states of a robot, as sensor_msgs/JointState.

    If `jointNames` is given, the joint states come from the arrays, otherwise from the robot `targetPrim`. Lengths and forces in
    the arrays are multiplied by k = 1 / `stageMetersPerUnit`, torques by k^2, as in Isaac Sim; k is 1 for metres. The published
    efforts of `targetPrim` were computed in the last physics step.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/JointState"

    target_prim: Target = In(
        required="joints",
        setup=True,
        doc="robot whose joints are published if `jointNames` is empty: its root prim, base link or articulation root",
    )
    topic_name: String = In(default="joint_states", setup=True)
    joint_names: Tokens = In(required="joints", doc="names of the joints in the arrays; if empty, `targetPrim` is used")
    joint_positions: Doubles = In(unit="rad, m")
    joint_velocities: Doubles = In(unit="rad/s, m/s")
    joint_efforts: Doubles = In(unit="N m, N")
    joint_dof_types: UChars = In(le=1, doc="type of each joint in the arrays: 0 for revolute, 1 for prismatic")
    stage_meters_per_unit: Float = In(gt=0.0, unset=True, unit="m", doc="length of a stage unit, for the arrays")
    sensor_time: Float = In(default=0.0, unit="s", doc="stamp for the arrays; if it is 0 or less, `timeStamp` is used")
    resolution: float = In(
        default=1e-4,
        ge=0.0,
        extension=True,
        doc="joint values are rounded to multiples of `resolution`; 0: not rounded",
    )

    articulation: Articulation | None = Bound()
    names: Sequence[str] = Bound()

    def setup(self, context: Context) -> None:
        """Look up the robot, if `targetPrim` is given, and create the publisher on `topicName`."""
        self.articulation, self.names = None, ()
        if self.target_prim:
            self.articulation = context.articulation(self.target_prim[0])
            self.names = context.joint_names(self.target_prim[0])
        super().setup(context)

    def message(self) -> messages.JointState:
        """Return the message with the joint states in the arrays, or with those of the robot.

        Raises:
            BadValueError: neither `jointNames` nor `targetPrim` is given, or a value cannot be published.
        """
        if self.joint_names:
            return self.message_of_arrays()
        if self.articulation is None:
            raise BadValueError("jointNames", (), "the names of the joints, unless targetPrim is given")
        robot = self.articulation
        return self.joint_state(self.time_stamp, self.names, robot.positions(), robot.velocities(), robot.efforts())

    def message_of_arrays(self) -> messages.JointState:
        """Return the message with the joint states in the arrays, converted from stage units to SI units.

        Raises:
            BadValueError: `stageMetersPerUnit` is not above 0 and finite, or the arrays differ in length.
        """
        scale = self.stage_meters_per_unit
        if not 0.0 < scale < float("inf"):
            raise BadValueError("stageMetersPerUnit", scale, "above 0 (wire it from IsaacReadJointState)")
        same_length(
            jointNames=self.joint_names,
            jointPositions=self.joint_positions,
            jointVelocities=self.joint_velocities,
            jointEfforts=self.joint_efforts,
            jointDofTypes=self.joint_dof_types,
        )
        k = 1.0 / scale
        length = np.where(self.joint_dof_types == _PRISMATIC, k, 1.0)
        torque = np.where(self.joint_dof_types == _PRISMATIC, k, k * k)
        time = self.sensor_time if self.sensor_time > 0.0 else self.time_stamp
        with np.errstate(all="ignore"):
            arrays = self.joint_positions * length, self.joint_velocities * length, self.joint_efforts * torque
        return self.joint_state(time, self.joint_names, *arrays)

    def joint_state(self, time: float, names: Sequence[str], *arrays: NDArray[np.float64]) -> messages.JointState:
        """Return the message with positions, velocities and efforts, rounded to multiples of `resolution`.

        Raises:
            BadValueError: `resolution` is negative or not finite, or the time is out of the range of builtin_interfaces/Time.
        """
        values = np.concatenate(arrays)
        if not 0.0 <= self.resolution < math.inf:
            raise BadValueError("resolution", self.resolution, "finite and 0 or more")
        if self.resolution:
            values = _rounded(values, 1.0 / self.resolution)
        joints = len(names)
        parts = values[:joints], values[joints : 2 * joints], values[2 * joints :]
        port = "timeStamp" if time is self.time_stamp else "sensorTime"
        return messages.JointState(header(time, "", port), list(names), *parts)


@lint("W211")
def lint_empty_joint_states(context: LintContext) -> None:
    """Warn about joint state publishers whose robot has no movable joint: they publish only empty messages."""
    for _, instance, node in context.nodes(ROS2PublishJointState):
        if not node.target_prim or node.joint_names:
            continue
        try:
            robot = context.stage.stands_for_robot(context.stage.find(node.target_prim[0]))
        except GraphError:  # reported by the dry setup
            continue
        if robot is not None and not robot.facts.get("joints", True):
            message = f"{instance.id} publishes empty messages: no joint of {robot.path} moves"
            context.findings.add("W211", message, instance.span, NO_JOINTS, related=instance.entry.via)


@lint("W215")
def lint_lengths_of_states(context: LintContext) -> None:
    """Warn about joint state arrays of different lengths, and about covariances that do not have 36 numbers."""
    for inputs, node in known_inputs(context, PublisherNode):
        if isinstance(node, ROS2PublishJointState) and inputs.length("joint_names"):
            states = "joint_positions", "joint_velocities", "joint_efforts", "joint_dof_types"
            inputs.warn_of_unequal("joint_names", *states)
        elif isinstance(node, ROS2PublishOdometry):
            for name in ("pose_covariance", "twist_covariance"):
                inputs.warn_of_length(name, 36, "a covariance has 6 x 6 numbers", may_be_empty=True)


def _rounded(values: NDArray[np.float64], steps: float) -> NDArray[np.float64]:
    """Return the numbers rounded to multiples of 1 / steps; numbers whose rounding overflows stay. May overwrite `values`."""
    if max(map(abs, values.tolist()), default=0.0) * max(steps, 1.0) < 1e300:  # nothing overflows: errstate costs time
        values *= steps
        np.rint(values, out=values)
        values /= steps
        return values
    with np.errstate(all="ignore"):
        rounded = np.rint(values * steps) / steps
    return np.where(np.isfinite(rounded), rounded, values)


class ROS2PublishOdometry(PublisherNode, type="isaacsim.ros2.bridge.ROS2PublishOdometry"):
    """Publishes a pose and a twist as nav_msgs/Odometry.

    Unless `publishRawVelocities` is true, velocities are projected onto three constant axes: front (`robotFront` projected onto
    the xy plane), side (up x front) and up. `orientation` does not rotate these axes, so give the velocities in the robot's
    body frame.
    """

    message_type: ClassVar[str] = "nav_msgs/msg/Odometry"

    odom_frame_id: String = In(default="odom", setup=True, doc="frame of the pose")
    chassis_frame_id: String = In(
        default="base_link", setup=True, doc="frame of the robot, whose pose is published; the twist is in this frame"
    )
    topic_name: String = In(default="odom", setup=True)
    publish_raw_velocities: bool = In(
        default=False, doc="true: publish the velocities unchanged; false: project them onto the axes of `robotFront`"
    )
    position: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m")
    orientation: Quaterniond = In(default=(0.0, 0.0, 0.0, 1.0), doc="quaternion (x, y, z, w)")
    linear_velocity: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m/s")
    angular_velocity: Vector3d = In(default=(0.0, 0.0, 0.0), unit="rad/s")
    robot_front: Vector3d = In(default=(1.0, 0.0, 0.0), doc="forward direction of the robot in its body frame")
    pose_covariance: Doubles = In(
        default=np.zeros(0),
        extension=True,
        doc="covariance of x, y, z, roll, pitch, yaw: 6 x 6 numbers, row by row; empty: zeros, which mean unknown",
    )
    twist_covariance: Doubles = In(
        default=np.zeros(0), extension=True, doc="covariance of the velocities: 6 x 6 numbers, like `poseCovariance`"
    )

    def setup(self, context: Context) -> None:
        """Create the publisher on `topicName`."""
        self.publisher = self.open(context, frame_id=self.odom_frame_id, child_frame_id=self.chassis_frame_id)

    def message(self) -> messages.Odometry:
        """Return the message with the pose and the velocities."""
        linear, angular = self.linear_velocity, self.angular_velocity
        if not self.publish_raw_velocities and self.robot_front != (1.0, 0.0, 0.0):
            linear, angular = self.along_front(linear), self.along_front(angular)
        pose = messages.Pose(messages.Point(*self.position), messages.Quaternion(*self.orientation))
        twist = messages.Twist(messages.Vector3(*linear), messages.Vector3(*angular))
        claim = self.publisher.claim
        return messages.Odometry(
            header(self.time_stamp, claim.frame_id),
            claim.child_frame_id,
            messages.PoseWithCovariance(pose, _covariance("poseCovariance", self.pose_covariance)),
            messages.TwistWithCovariance(twist, _covariance("twistCovariance", self.twist_covariance)),
        )

    def along_front(self, velocity: Vector3d) -> Vector3d:
        """Return the components of a velocity along the front, side and up axes.

        Raises:
            BadValueError: `robotFront` has no direction in the xy plane.
        """
        x, y, _ = self.robot_front
        length = math.hypot(x, y)
        if not 0.0 < length < math.inf:
            raise BadValueError("robotFront", self.robot_front, "finite, and not along the up axis")
        x, y = x / length, y / length
        return velocity[0] * x + velocity[1] * y, velocity[1] * x - velocity[0] * y, velocity[2]


def _covariance(port: str, numbers: Doubles) -> Doubles:
    if len(numbers) not in (0, 36):
        raise BadValueError(port, numbers, "36 numbers, or empty")
    return numbers if len(numbers) else _UNKNOWN


_UNKNOWN = read_only(np.zeros(36))
