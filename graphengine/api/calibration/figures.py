"""Results of a calibration, in SI units; None stands for a value that could not be measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Kind = Literal["straight", "turn", "sideways"]
Kinematics = Literal["differential", "mecanum", "ackermann", ""]
TURN_MARGIN = 1.5
"""Bound of turns and of sideways motions, as a multiple of the bound of straight motions."""


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity of the base in its own frame: forward and to the left, m/s, and counter-clockwise, rad/s."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """A test drive with a constant command, measured once the velocity is steady.

    Attributes:
        name: `forward`, `backward`, `turn_left`, `turn_right`, `arc_left`, `arc_right`, `sideways_left` or `sideways_right`.
        kind: component of the velocity that is evaluated: `straight` (forward), `sideways`, or `turn` (turn rate, also for arcs).
        commanded: velocity that was commanded.
        reached: mean velocity of the base link.
        share: reached / commanded velocity, of the component that `kind` names.
        settle_time: time from the command until the velocity stays within 5 % of the reached one, s.
        lateral_drift: displacement across the commanded direction, m per metre; None for turns.
        heading_drift: change of heading, rad per metre; None for turns.
        position_drift: displacement of the base link by one full turn on the spot, m; None for other motions.
        slip: share of the wheels' motion that the base does not follow, with the wheel radii and track of the robot description.
    """

    name: str
    kind: Kind
    commanded: Twist
    reached: Twist
    share: float
    settle_time: float | None = None
    lateral_drift: float | None = None
    heading_drift: float | None = None
    position_drift: float | None = None
    slip: float | None = None

    def is_within(self, bound: float) -> bool:
        """Return whether `share` differs from 1 by at most `bound`, or by `TURN_MARGIN * bound` for a turn or sideways motion."""
        return abs(self.share - 1.0) <= (bound if self.kind == "straight" else TURN_MARGIN * bound)


@dataclass(frozen=True, slots=True)
class DrivenWheel:
    """A driven wheel: joint, rolling radius (distance per angle, m), and the side of the base it is on, if known."""

    joint: str
    radius: float
    side: Literal["left", "right", ""] = ""


@dataclass(frozen=True, slots=True, eq=False)
class Square:
    """A square driven by time, without feedback. Paths are those of the point about which the robot turns on the spot.

    Attributes:
        direction: `counterclockwise` or `clockwise`.
        side: commanded length of a side, m.
        position_error: distance between the ends of the true and the commanded path, m.
        heading_error: true minus commanded heading at the end, rad.
        commanded: path of an ideal robot, rows of x (m), y (m), yaw (rad); the paths begin at 0, 0, 0.
        truth: true path.
        odometry: path that each odometry topic reports.
    """

    direction: Literal["clockwise", "counterclockwise"]
    side: float
    position_error: float
    heading_error: float
    commanded: Floats = field(repr=False)
    truth: Floats = field(repr=False)
    odometry: dict[str, Floats] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Alphas:
    """Noise parameters of nav2_amcl's motion models that correspond to the errors of an odometry.

    nav2_amcl (sample_motion_model_odometry of Thrun, Burgard, Fox: Probabilistic Robotics, 5.4) gives a motion of distance d
    and angle a these variances: rotation alpha1 a^2 + alpha2 d^2, translation alpha3 d^2 + alpha4 a^2, and across the motion,
    in the omni model, alpha5 d^2. Each parameter is the mean square error over steps of 0.25 m or 0.2 rad, at which AMCL
    updates by default, divided by the square of the step.
    """

    alpha1: float | None = None
    alpha2: float | None = None
    alpha3: float | None = None
    alpha4: float | None = None
    alpha5: float | None = None


@dataclass(frozen=True, slots=True)
class Covariances:
    """Variances of an odometry that grow with the motion, as ComputeWheelOdometry takes them.

    Each is the mean of error^2 / motion over steps of 0.25 m or 0.2 rad.

    Attributes:
        distance_variance: variance of the distance, m2 per m.
        heading_variance_by_distance: variance of the heading when driving straight, rad2 per m.
        heading_variance_by_turn: variance of the heading when turning, rad2 per rad.
    """

    distance_variance: float | None = None
    heading_variance_by_distance: float | None = None
    heading_variance_by_turn: float | None = None


@dataclass(frozen=True, slots=True)
class Odometry:
    """Errors of an odometry topic: odometry minus truth, the mean of both directions.

    Attributes:
        topic: name of the topic.
        frame: child frame of the odometry, whose true pose is compared.
        distance_error: m per metre of a straight drive.
        lateral_error: m per metre of a straight drive; the larger of both directions, without sign.
        heading_error: rad per metre of a straight drive; the larger of both directions, without sign.
        turn_error: rad per full turn; positive if the odometry turns further than the robot.
        turn_position_error: m per full turn.
        sideways_error: m per metre of a sideways drive.
        square_position_error: at the end of a square, m; the larger of both directions.
        square_heading_error: at the end of a square, rad; the larger of both directions, without sign.
        alphas: parameters of AMCL.
        covariances: parameters of a covariance model.
    """

    topic: str
    frame: str
    distance_error: float | None = None
    lateral_error: float | None = None
    heading_error: float | None = None
    turn_error: float | None = None
    turn_position_error: float | None = None
    sideways_error: float | None = None
    square_position_error: float | None = None
    square_heading_error: float | None = None
    alphas: Alphas = Alphas()
    covariances: Covariances = Covariances()

    def is_true(self) -> bool:
        """Return whether the odometry equals the true motion: all measured errors are below 5e-5, each in its unit."""
        errors = [getattr(self, one.name) for one in fields(self) if one.name.endswith("_error")]
        measured = [abs(error) for error in errors if error is not None]
        return bool(measured) and max(measured) < 5e-5


@dataclass(frozen=True, slots=True)
class ImuNoise:
    """Noise and bias of an IMU while the robot stands.

    Attributes:
        topic: name of the topic.
        rate: messages per second.
        gyro_noise: standard deviation of the angular velocity, of the noisiest axis, rad/s.
        gyro_bias: magnitude of the mean angular velocity, rad/s.
        accelerometer_noise: standard deviation of the acceleration, of the noisiest axis, m/s2.
        gravity: magnitude of the mean acceleration, m/s2.
    """

    topic: str
    rate: float
    gyro_noise: float
    gyro_bias: float
    accelerometer_noise: float
    gravity: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """Measurements of a robot in test drives on a flat floor; `Scene.calibrate` returns them.

    Attributes:
        robot: name of the robot in its scene.
        command_topic: topic that the test drives use.
        command_type: its message type.
        speed: commanded speed, m/s.
        turn_speed: commanded turn rate, rad/s.
        moves: whether the robot moves and stays upright; `notes` has the reason if not.
        kinematics: `differential` if the robot turns on the spot, `mecanum` if it also goes sideways, `ackermann` if it
            turns in arcs only; empty if it does not turn.
        motions: test drives with a constant command.
        wheels: driven wheels.
        wheel_radius: mean rolling radius of the wheels, m, with which wheel odometry measures the true distance.
        track: distance between left and right wheels with which odometry measures the true turn, m; for mecanum wheels the
            sum of track and wheel base.
        wheel_base: distance between the axles with which the steering angles give the true turn rate, m; ackermann only.
        turning_centre: point of the base link's frame about which the robot turns on the spot, x and y, m.
        squares: a square in each direction.
        odometry: errors of each odometry topic.
        imus: noise of each IMU.
        notes: what could not be measured, with the reason.
    """

    robot: str
    command_topic: str
    command_type: str
    speed: float
    turn_speed: float
    moves: bool
    kinematics: Kinematics = ""
    motions: tuple[Motion, ...] = ()
    wheels: tuple[DrivenWheel, ...] = ()
    wheel_radius: float | None = None
    track: float | None = None
    wheel_base: float | None = None
    turning_centre: tuple[float, float] | None = None
    squares: tuple[Square, ...] = ()
    odometry: tuple[Odometry, ...] = ()
    imus: tuple[ImuNoise, ...] = ()
    notes: tuple[str, ...] = ()

    def outside(self, bound: float) -> tuple[Motion, ...]:
        """Return the motions for which `Motion.is_within(bound)` is false."""
        return tuple(motion for motion in self.motions if not motion.is_within(bound))

    def to_data(self) -> dict[str, Any]:
        """Return the figures as plain data for JSON, without the paths of the squares."""
        data = asdict(self)
        for square in data["squares"]:
            for path in ("commanded", "truth", "odometry"):
                del square[path]
        rounded: dict[str, Any] = _rounded(data)
        return rounded


def _rounded(value: Any) -> Any:
    """Return plain data with floats rounded to 9 decimals; further digits are rounding noise."""
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return round(value, 9) + 0.0 if isinstance(value, float) else value
