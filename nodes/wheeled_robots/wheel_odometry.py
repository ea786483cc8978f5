"""The node that computes the odometry of a wheeled base from its wheel encoders, and a lint of its wheel geometry."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.compiler.lint_registry import lint
from graphengine.devices.backend import joint_numbers
from graphengine.format.stateful import Shared
from graphengine.node import BadValueError, Bound, Clock, Context, ContextError, ExecOut, In, Out, State
from graphengine.node.types import Double2, Doubles, Int, Quaterniond, Token, Tokens, Vector3d, read_only
from graphengine.nodes.checked import check_finite, check_outcome
from graphengine.nodes.core.articulation import RobotNode, robot_of
from graphengine.nodes.wheeled_robots import wheel_motion
from graphengine.nodes.wheeled_robots.dead_reckoning import Floats, Planar, Propagation, in_space, moved, to_origin
from graphengine.nodes.wheeled_robots.geometry_check import Effects, compare_geometry

if TYPE_CHECKING:
    from graphengine.compiler.lint_registry import LintContext

_JOINTS = {
    "differential": "set leftJoints and rightJoints, with one joint or more in each",
    "mecanum": "set leftJoints and rightJoints, with [front, back] in each",
    "ackermann": "set leftJoints and rightJoints, with one joint or more in each, and steeringJoints: [left, right] or [middle]",
}
"""Message texts: the joints that each kind of kinematics needs, by its token."""
_Moved = tuple[float, float, float, float]
"""A motion, forward (m), left (m) and counter-clockwise turn (rad), and its duration (s)."""
_UNKNOWN = read_only(np.zeros(36))


@dataclass(frozen=True, slots=True)
class WheelGeometry(Shared):
    """The numbers that an odometry derives from its inputs and the steering angles.

    Attributes:
        inputs: numeric inputs of the node.
        travel_per_count: distance that each wheel rolls per tick of its encoder or per rad, m.
        forward: matrix (3, wheels) from wheel travel to base motion.
        quantization: covariance of a motion that results from the quantization of encoders, 9 numbers row by row.
    """

    inputs: tuple[Any, ...]
    travel_per_count: Sequence[float]
    forward: Floats
    quantization: Sequence[float]


class ComputeWheelOdometry(RobotNode, type="graphengine.wheeled_robots.ComputeWheelOdometry"):
    """Computes odometry from wheel encoders, as the controllers of real robots do; IsaacComputeOdometry outputs the ground truth.

    The base moves in a plane. The output pose is relative to the pose at the first execution after play, and drifts as wheels
    slip. If the state of the world is reset, but not the time, the output pose does not change, because the wheels did not roll.
    `kinematics` is one of:

    - `differential`: left and right wheels that do not steer, any number on each side. For a skid-steered base with track T and
      distance B between its axles, 1 + (B / T)^2 is a good initial guess of `wheelDistanceMultiplier`.
    - `mecanum`: two wheels on each side, [front, back], whose roller axes form an X seen from above.
    - `ackermann`: the wheels of the unsteered axle, and one or two steered wheels on the other axle.

    Kinematics and integration follow diff_drive_controller, mecanum_drive_controller and ackermann_steering_controller of
    ros2_controllers: motions between two executions are straight lines or arcs. If a base has more wheels than needed and their
    encoders disagree, the motion is the least-squares solution. `wheelDistance` corresponds to the controllers'
    `wheel_separation` or track width, and `velocityWindow` to their `velocity_rolling_window_size`.

    The covariances follow Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 5.2.4: variances grow in proportion
    to distance and turn, and errors of the heading become errors of the position.
    """

    kinematics: Token = In(default="differential", setup=True, tokens=tuple(_JOINTS), doc="kinematics of the base")
    left_joints: Tokens = In(required=True, setup=True, doc="names of the joints of the left wheels")
    right_joints: Tokens = In(required=True, setup=True, doc="names of the joints of the right wheels")
    steering_joints: Tokens = In(
        default=(), setup=True, doc="for `ackermann`: names of the steering joints, [left, right] or [middle]"
    )
    wheel_radius: float = In(gt=0.0, required=True, unit="m", doc="radius of the wheels")
    left_wheel_radius_multiplier: float = In(
        default=1.0, doc="factor for the radius of the left wheels; negative for reversed joint axes"
    )
    right_wheel_radius_multiplier: float = In(
        default=1.0, doc="factor for the radius of the right wheels; negative for reversed joint axes"
    )
    wheel_distance: float = In(
        default=0.0, ge=0.0, required=True, unit="m", doc="distance between the left and right wheels"
    )
    wheel_distance_multiplier: float = In(default=1.0, gt=0.0, unit="m/m", doc="calibrating factor for `wheelDistance`")
    wheel_base: float = In(
        default=0.0,
        unit="m",
        doc="for `mecanum` and `ackermann`: distance between the axles; negative if the steered axle is behind",
    )
    steering_distance: float = In(
        default=0.0,
        ge=0.0,
        unit="m",
        doc="for `ackermann`: distance between the steering axes of the two steered wheels; if 0, `wheelDistance`",
    )
    steering_multiplier: float = In(
        default=1.0, doc="steering angle divided by joint position; -1 if the axes of the steering joints point down"
    )
    center_position: Double2 = In(
        default=(0.0, 0.0),
        unit="m",
        doc="position of the middle of the wheels (for `ackermann`, of the unsteered axle) in the frame whose odometry is "
        "computed",
    )
    ticks_per_revolution: float = In(
        default=0.0, ge=0.0, setup=True, doc="encoder ticks per turn of a wheel; 0: angles are exact"
    )
    slip: float = In(
        default=0.0,
        ge=0.0,
        unit="m/sqrt(m)",
        doc="standard deviation of the random error of a wheel's travel after 1 m; it grows with the square root of the travel",
    )
    velocity_window: Int = In(default=10, ge=1, doc="number of executions to average the velocities over")
    distance_variance: float = In(default=0.0, ge=0.0, unit="m2/m", doc="variance of the distance, per metre driven")
    heading_variance_by_distance: float = In(default=0.0, ge=0.0, unit="rad2/m", doc="heading variance per metre")
    heading_variance_by_turn: float = In(default=0.0, ge=0.0, unit="rad2/rad", doc="heading variance per radian")
    exec_out = ExecOut()
    position: Vector3d = Out(unit="m", doc="position in the frame of the pose at the first execution; z is 0")
    orientation: Quaterniond = Out(
        default=(0.0, 0.0, 0.0, 1.0),
        doc="orientation (x, y, z, w) relative to the pose at the first execution; a rotation about z",
    )
    linear_velocity: Vector3d = Out(unit="m/s", doc="velocity in the base's frame")
    angular_velocity: Vector3d = Out(unit="rad/s", doc="angular velocity in the base's frame")
    pose_covariance: Doubles = Out(
        default=_UNKNOWN,
        doc="6 x 6 covariance of x, y, z, roll, pitch and yaw, row by row; all 0 (unknown) if the three variance inputs are 0",
    )
    twist_covariance: Doubles = Out(
        default=_UNKNOWN,
        doc="6 x 6 covariance of the velocities, in the order of `poseCovariance`; it includes the quantization of the encoders, "
        "and is all 0 (unknown) if the three variance inputs are 0",
    )

    clock: Clock = Bound()
    wheels: list[int] = Bound()
    steering: list[int] = Bound()
    random: np.random.Generator = Bound()
    known: WheelGeometry | None = Bound()
    propagation: Propagation = Bound()
    last: tuple[float, Sequence[float], int] | None = State(default=None)
    pose: Planar = State(default=(0.0, 0.0, 0.0))
    covariance: Sequence[float] = State(default=(0.0,) * 9)
    window: tuple[_Moved, ...] = State(default=())

    def setup(self, context: Context) -> None:
        """Look up the joints of the wheels. The next execution takes the first reading of the encoders.

        Raises:
            ContextError: the numbers of wheel joints or steering joints do not fit `kinematics`.
        """
        left, right, steering = len(self.left_joints), len(self.right_joints), len(self.steering_joints)
        complete = left == right == 2 if self.kinematics == "mecanum" else left and right
        if not complete or (self.kinematics == "ackermann" and steering not in (1, 2)):
            text = f"the joints do not fit {self.kinematics} kinematics"
            raise ContextError(text, self.kinematics, _JOINTS[self.kinematics])
        self.articulation, self.clock, self.random = context.articulation(self.prim()), context.clock, context.random()
        self.wheels = joint_numbers(self.articulation, self.left_joints + self.right_joints)
        self.steering = joint_numbers(self.articulation, self.steering_joints) if steering else []
        self.last = self.known = None
        self.propagation = Propagation()

    def compute(self) -> None:
        """Add the motion since the previous execution to the pose, and set the outputs.

        Raises:
            BadValueError: the geometry does not determine the motion of the base, or a number is not finite or out of range.
        """
        positions, now, resets = self.articulation.positions().tolist(), self.clock.time, self.articulation.resets
        geometry = self.geometry(positions)
        counts = self.counted([positions[wheel] for wheel in self.wheels])
        if self.last is None or self.last[2] != resets:
            self.last, self.window = (now, counts, resets), ()
        elif now > (before := self.last[0]):
            turned = zip(geometry.travel_per_count, counts, self.last[1], strict=True)
            travel = self.with_slip([distance * (count - earlier) for distance, count, earlier in turned])
            motion = geometry.forward.dot(np.array(travel))
            self.advance(motion.tolist(), now - before, geometry.quantization)
            self.last = (now, counts, resets)

    def geometry(self, positions: Sequence[float]) -> WheelGeometry:
        """Return the geometry for the current inputs and joint positions (rad); without steering, only inputs change it.

        Raises:
            BadValueError: the geometry does not determine the motion of the base, or an input is not finite or out of range.
        """
        inputs = _INPUTS(self)
        if self.known is None or self.steering or self.known.inputs != inputs:
            self.check_numbers()
            with np.errstate(all="ignore"):
                travel = self.travel_per_count()
                angles = [positions[joint] * self.steering_multiplier for joint in self.steering]
                forward = self.forward_kinematics(angles)
                self.known = WheelGeometry(inputs, travel.tolist(), forward, self.quantization(forward * travel))
        return self.known

    def check_numbers(self) -> None:
        """Check the numeric inputs; wires can set them to any number.

        Raises:
            BadValueError: a number is not finite or is below its smallest legal value.
        """
        check_finite(self, *_NUMBERS)
        for field, least in _LEAST.items():
            if getattr(self, field) < least:
                raise BadValueError(type(self).fields[field].name, getattr(self, field), f"{least} or more")

    def counted(self, angles: Sequence[float]) -> Sequence[float]:
        """Return the encoder readings at these wheel angles (rad): ticks, or the angles (rad) if `ticksPerRevolution` is 0."""
        if not self.ticks_per_revolution:
            return angles
        ticks_per_radian = self.ticks_per_revolution / math.tau
        return [angle * ticks_per_radian // 1.0 for angle in angles]

    def travel_per_count(self) -> Floats:
        """Return the distance (m) that each wheel rolls per tick of its encoder, or per rad if `ticksPerRevolution` is 0.

        Raises:
            BadValueError: `wheelRadius` is 0.
        """
        if not self.wheel_radius:
            raise BadValueError("wheelRadius", self.wheel_radius, "other than 0")
        sides = self.left_wheel_radius_multiplier, self.right_wheel_radius_multiplier
        angle = math.tau / self.ticks_per_revolution if self.ticks_per_revolution else 1.0
        return angle * self.wheel_radius * np.repeat(sides, (len(self.left_joints), len(self.right_joints)))

    def forward_kinematics(self, steering: Sequence[float]) -> Floats:
        """Return the matrix (3, wheels) from wheel travel to base motion, at these steering angles (rad).

        Raises:
            BadValueError: the geometry does not determine the motion of the base.
        """
        left, right, base = len(self.left_joints), len(self.right_joints), self.wheel_base
        distance = self.wheel_distance * self.wheel_distance_multiplier
        try:
            if self.kinematics == "differential":
                matrix = wheel_motion.differential(left, right, distance)
            elif self.kinematics == "mecanum":
                matrix = wheel_motion.mecanum(distance, base)
            else:
                bend = wheel_motion.curvature(steering, base, self.steering_distance or self.wheel_distance)
                matrix = wheel_motion.ackermann(left, right, distance, bend)
        except ZeroDivisionError:
            ports = "wheelDistance, wheelDistanceMultiplier, wheelBase"
            given = (self.wheel_distance, self.wheel_distance_multiplier, base)
            legal = f"values that determine the motion of a base with {self.kinematics} kinematics"
            raise BadValueError(ports, given, legal) from None
        return to_origin(self.center_position) @ matrix

    def with_slip(self, travel: Sequence[float]) -> Sequence[float]:
        """Return the travel of the wheels (m) with random errors; return it unchanged if `slip` is 0."""
        if not self.slip:
            return travel
        spread = [self.slip * math.sqrt(abs(distance)) for distance in travel]
        if not math.isfinite(sum(spread)):
            check_outcome(self, *spread)
        errors = self.random.standard_normal(len(spread)).tolist()
        return [distance + most * error for distance, most, error in zip(travel, spread, errors, strict=True)]

    def advance(self, motion: Sequence[float], elapsed: float, quantization: Sequence[float]) -> None:
        """Add a motion to the pose, and set the outputs.

        Args:
            motion: motion of the base: forward (m), left (m), counter-clockwise turn (rad).
            elapsed: duration of the motion, s.
            quantization: covariance of the motion that results from the quantization of encoders, 9 numbers row by row.
        """
        ahead, left, turn = motion
        window = (*self.window, (ahead, left, turn, elapsed))[-self.velocity_window :]
        *recent, duration = _total(window)
        pose, step = self.pose, (ahead, left, turn)
        x, y, yaw = after = moved(pose, step)
        v_x, v_y, turn_rate = velocity = [part / duration for part in recent]
        outcome, covariance, of_pose, of_twist = [*after, *velocity], self.covariance, _UNKNOWN, _UNKNOWN
        if self.distance_variance or self.heading_variance_by_distance or self.heading_variance_by_turn:
            covariance = self.propagation.propagate(covariance, pose, after, turn, self.noise(step))
            a, b, c = self.noise(recent)
            twist, square = [*quantization], duration**2
            twist[0], twist[4], twist[8] = a + twist[0], b + twist[4], c + twist[8]
            twist = [variance / square for variance in twist]
            of_pose, of_twist = in_space(covariance), in_space(twist)
            outcome += (*covariance, *twist)
        if not math.isfinite(sum(outcome)):
            check_outcome(self, *outcome)
        self.window, self.pose, self.covariance = window, after, covariance
        self.position, self.orientation = (x, y, 0.0), (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))
        self.linear_velocity, self.angular_velocity = (v_x, v_y, 0.0), (0.0, 0.0, turn_rate)
        self.pose_covariance, self.twist_covariance = of_pose, of_twist

    def noise(self, motion: Sequence[float]) -> Planar:
        """Return the variances of the parts of a motion that result from the three variance inputs."""
        ahead, left, turn = map(abs, motion)
        heading = self.heading_variance_by_distance * math.hypot(ahead, left) + self.heading_variance_by_turn * turn
        return self.distance_variance * ahead, self.distance_variance * left, heading

    def quantization(self, motion_per_count: Floats) -> list[float]:
        """Return the covariance of a motion that results from the quantization of two encoder readings, 9 numbers row by row.

        Each reading is wrong by at most half a tick. The numbers are 0 if `ticksPerRevolution` is 0.

        Args:
            motion_per_count: matrix (3, wheels) from encoder counts to motions.
        """
        if not self.ticks_per_revolution:
            return [0.0] * 9
        covariance: list[float] = (motion_per_count @ motion_per_count.T / 6.0).ravel().tolist()
        return covariance


def _total(window: Sequence[_Moved]) -> _Moved:
    """Return the sum of motions and of their durations; `sum` would round differently from Python 3.12 on."""
    ahead, left, turn, duration = window[0]
    for more_ahead, more_left, more_turn, more_duration in window[1:]:
        ahead += more_ahead
        left += more_left
        turn += more_turn
        duration += more_duration
    return ahead, left, turn, duration


_LEAST = {
    "slip": 0.0,
    "velocity_window": 1,
    "distance_variance": 0.0,
    "heading_variance_by_distance": 0.0,
    "heading_variance_by_turn": 0.0,
}
"""A dict from inputs to their smallest legal values, which each execution checks because wires may set these inputs."""
_FIELDS = ComputeWheelOdometry.fields.values()
_NUMBERS = tuple(port.field for port in _FIELDS if port.side == "inputs" and str(port.type).startswith("double"))
_INPUTS = operator.attrgetter(*_NUMBERS, "velocity_window")


@lint("W201")
def lint_geometry_of_odometry(context: LintContext) -> None:
    """Warn if `wheelRadius` or `wheelDistance` of a differential base with two wheels differs from the geometry of the robot."""
    for _, source, node in context.nodes(ComputeWheelOdometry):
        joints = node.left_joints + node.right_joints
        if node.kinematics != "differential" or len(joints) != 2:
            continue
        robot = robot_of(context, node)
        if robot is not None:
            compare_geometry(context, source, node, robot, joints, _EFFECTS)


_EFFECTS: Effects = (
    lambda factor: f"odometry will report {factor:.3g} of the true distance",
    lambda factor: f"odometry will report {1.0 / factor:.3g} of the true turn",
)
