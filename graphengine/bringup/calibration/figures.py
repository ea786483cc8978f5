"""Classes for the results of a calibration. Values are in SI units; None stands for a value that was not measured."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Side = Literal["left", "right", ""]
Kind = Literal["straight", "turn", "sideways"]
Kinematics = Literal["differential", "mecanum", "omni", "ackermann", ""]
CREEP = 1e-3
"""Largest speed of a robot that counts as parked, m/s."""
STOP_MARGIN = 1.2
"""Largest ratio of a stopping distance to that of an ideal stop."""
SKID_MARGIN = 5.0
"""Ratio of the bound for turns and arcs of skid-steered bases to the bound for straight motions."""
TURN_MARGIN = 1.5
"""Ratio of the bound for turns and sideways motions to the bound for straight motions."""


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity of the base link in its own frame: x forward and y to the left, m/s; yaw counter-clockwise, rad/s."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """A test drive with a constant command, measured once the velocity is steady.

    Attributes:
        name: `forward`, `backward`, `turn_left`, `turn_right`, `arc_left`, `arc_right`, `sideways_left` or `sideways_right`;
            `slow_arc_left` and so on at 0.3, and `full_arc_left` and so on at 1.0 of the limits of the controller; `uphill` and
            `downhill` on a slope of 5 degrees.
        kind: component of the velocity that is evaluated: `straight` (forward), `sideways`, or `turn` (turn rate, also for arcs).
        commanded: commanded velocity.
        reached: mean velocity of the base link.
        share: ratio of reached to commanded velocity, for the component that `kind` names.
        settle_time: time from the first command until the velocity stays within 5 % of `reached`, s.
        lateral_drift: displacement across the commanded direction, m per metre of the drive; None for turns.
        heading_drift: change of heading, rad per metre of the drive; None for turns.
        position_drift: distance by which one full turn on the spot displaces the base link, m; None for other motions.
        slip: share of the wheels' rolling that does not move the base: 1 - true motion / motion by the wheel angles, computed
            with the wheel radii and the track in the robot description.
        speed_share: ratio of reached to commanded forward velocity in an arc; None for other motions.
        sideslip: angle from the heading of the base link to the motion of the turning centre in an arc, rad; None for other
            motions.
        skids: whether the base is skid-steered.
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
    speed_share: float | None = None
    sideslip: float | None = None
    skids: bool = False

    def is_within(self, bound: float) -> bool:
        """Return whether the reached velocity is close to the commanded one: `share` differs from 1 by at most `bound`.

        For a turn or a sideways motion, and for the speed in an arc, the largest difference is `TURN_MARGIN * bound`. For turns
        and arcs of a skid-steered base, the difference is `SKID_MARGIN * bound`, because no track suits all arcs.
        """
        worst = max(abs(share - 1.0) for share in (self.share, self.speed_share) if share is not None)
        return worst <= self.margin * bound

    @property
    def margin(self) -> float:
        """Ratio of the bound for this motion to the bound for straight motions."""
        if self.kind == "straight":
            return 1.0
        return SKID_MARGIN if self.skids and self.kind == "turn" else TURN_MARGIN


@dataclass(frozen=True, slots=True)
class Stop:
    """A stop from full speed on a flat floor.

    Attributes:
        speed: speed before the stop, m/s.
        distance: distance from the command to stop until the robot stands, m.
        deceleration: limit of the deceleration in the robot's controllers, m/s2; None without a limit.
    """

    speed: float
    distance: float
    deceleration: float | None

    @property
    def ratio(self) -> float | None:
        """The distance divided by v^2 / 2a, the distance of an ideal stop with the deceleration limit; None without a limit."""
        return self.distance / (self.speed**2 / (2.0 * self.deceleration)) if self.deceleration else None

    def is_within(self) -> bool:
        """Return whether the distance is at most `STOP_MARGIN` times that of an ideal stop, or there is no limit."""
        return self.ratio is None or self.ratio <= STOP_MARGIN


@dataclass(frozen=True, slots=True)
class Slope:
    """A robot parked on a slope of 5 degrees with a command to stand.

    Attributes:
        along: speed at which the robot creeps while it faces up the slope, m/s.
        across: speed at which the robot creeps while it stands across the slope, m/s.
    """

    along: float
    across: float

    def is_within(self) -> bool:
        """Return whether the robot creeps by at most `CREEP` in both directions."""
        return max(self.along, self.across) <= CREEP


@dataclass(frozen=True, slots=True)
class DrivenWheel:
    """A driven wheel.

    Attributes:
        joint: name of the wheel's joint.
        radius: rolling radius, m: distance that the base travels per rad of the wheel.
        side: side of the base; empty if unknown.
    """

    joint: str
    radius: float
    side: Side = ""


@dataclass(frozen=True, slots=True, eq=False)
class Square:
    """A square that the robot drove with timed commands, without feedback.

    Each path is an array with rows of x (m), y (m) and yaw (rad), and begins at 0, 0, 0. All paths are those of the point about
    which the robot turns on the spot.

    Attributes:
        direction: `counterclockwise` or `clockwise`.
        side: commanded length of a side, m.
        position_error: distance between the ends of the true and the commanded path, m.
        heading_error: true minus commanded heading at the end, rad.
        commanded: path of an ideal robot that follows the commands exactly.
        truth: true path.
        odometry: a dict from odometry topics to the paths that they report.
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
    """Noise parameters of nav2_amcl's motion models, computed from the measured errors of an odometry topic.

    For a motion of distance d and angle a, nav2_amcl (sample_motion_model_odometry of Thrun, Burgard, Fox: Probabilistic
    Robotics, 5.4) assumes the variances alpha1 a^2 + alpha2 d^2 of the rotation and alpha3 d^2 + alpha4 a^2 of the translation.
    In the omni model, the translation across the motion has the variance alpha5 d^2. Each parameter is the mean of the squared
    ratio error / motion over steps of 0.25 m or 0.2 rad, the default steps at which AMCL updates.
    """

    alpha1: float | None = None
    alpha2: float | None = None
    alpha3: float | None = None
    alpha4: float | None = None
    alpha5: float | None = None


@dataclass(frozen=True, slots=True)
class Covariances:
    """Variances per distance or angle, computed from the measured errors of an odometry topic, for ComputeWheelOdometry.

    Each value is the mean of error^2 / motion over steps of 0.25 m or 0.2 rad.

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
    """Errors of an odometry topic: odometry minus truth.

    Each test is driven in both directions (forward and backward, or left and right). Errors are the mean of the two directions
    unless another rule is given.

    Attributes:
        topic: name of the topic.
        frame: child frame of the odometry, whose true pose is the truth.
        distance_error: error of the distance, m per metre of a straight drive.
        lateral_error: error across the drive, m per metre of a straight drive; the larger magnitude of both directions.
        heading_error: error of the heading, rad per metre of a straight drive; the larger magnitude of both directions.
        turn_error: error of the angle, rad per full turn; positive if the odometry turns further than the robot.
        turn_position_error: error of the position, m per full turn on the spot.
        sideways_error: error of the distance, m per metre of a sideways drive.
        square_position_error: error of the position at the end of a square, m; the larger error of both directions.
        square_heading_error: error of the heading at the end of a square, rad; the larger magnitude of both directions.
        alphas: noise parameters for AMCL.
        covariances: variances for ComputeWheelOdometry.
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
        gyro_noise: standard deviation of the angular velocity about the noisiest axis, rad/s.
        gyro_bias: magnitude of the mean angular velocity, rad/s.
        accelerometer_noise: standard deviation of the acceleration along the noisiest axis, m/s2.
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
    """Measurements of a robot in test drives on a flat floor; `calibrate` returns them.

    Attributes:
        robot: name of the robot in its scene.
        command_topic: topic on which the test drives publish commands; empty if the robot has no command topic.
        command_type: message type of the command topic.
        speed: commanded speed, m/s.
        turn_speed: commanded turn rate, rad/s.
        moves: whether the robot moves and stays upright; if not, `notes` has the reason.
        kinematics: `differential` if the robot turns on the spot, `mecanum` if it also drives sideways, `omni` if it also drives
            sideways and its wheels have axles in several directions, `ackermann` if it turns only in arcs; empty if the robot
            does not turn.
        motions: test drives with a constant command.
        wheels: driven wheels.
        wheel_radius: mean rolling radius of the driven wheels, m; wheel odometry with this radius gives the true distance.
        track: effective distance between left and right wheels, m; wheel odometry with this track gives the true turn. For
            mecanum wheels, the sum of track and wheel base.
        wheel_base: effective distance between the axles, m; with this wheel base, the steering angles give the true turn rate.
            Only for `ackermann`.
        turning_centre: point about which the robot turns on the spot, x and y in the base link's frame, m.
        stop: measurements of a stop from full speed; None if the robot does not turn, or fell over.
        slope: creep of the parked robot on a slope; None if the robot fell over.
        squares: test drives along squares, counter-clockwise and clockwise.
        odometry: errors of each odometry topic.
        imus: noise of each IMU.
        notes: sentences that name values without a measurement, and the reasons.
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
    stop: Stop | None = None
    slope: Slope | None = None
    squares: tuple[Square, ...] = ()
    odometry: tuple[Odometry, ...] = ()
    imus: tuple[ImuNoise, ...] = ()
    notes: tuple[str, ...] = ()

    def outside(self, bound: float) -> tuple[Motion, ...]:
        """Return the motions for which `Motion.is_within(bound)` is false."""
        return tuple(motion for motion in self.motions if not motion.is_within(bound))

    def to_data(self) -> dict[str, Any]:
        """Return the results as dicts, lists and rounded numbers for JSON, without the paths of the squares."""
        data = asdict(self)
        for square in data["squares"]:
            for path in ("commanded", "truth", "odometry"):
                del square[path]
        # Digits beyond 9 decimals are rounding noise.
        rounded: dict[str, Any] = json.loads(json.dumps(data), parse_float=lambda text: round(float(text), 9) + 0.0)
        return rounded
