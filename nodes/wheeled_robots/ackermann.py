"""The controller of four-wheeled bases with two steered wheels."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import BadValueError, Doubles, ExecIn, ExecOut, In, Node, Out, State
from graphengine.nodes.checked import check_outcome
from graphengine.nodes.known_inputs import LENGTHS
from graphengine.nodes.wheeled_robots.limits import limited, ramped


class AckermannController(Node, type="isaacsim.robot.wheeled_robots.AckermannController"):
    """Computes the steering angles and speeds with which four wheels roll about one turning centre.

    `steeringAngle` d is the steering angle of a bicycle with the same wheel base. With `wheelBase` b and `trackWidth` t, let
    k = 1 - (t / 2b) tan d for left wheels and k = 1 + (t / 2b) tan d for right wheels. Wheels that are not steered roll at
    k times `speed`. Steered wheels have the steering angle atan(tan d / k) and roll at sqrt(k^2 + (tan d)^2) times `speed`.

    With a `trackWidth` of 0, both wheels of an axle get the command of a bicycle's wheel. Some joints need the command with the
    opposite sign: steering joints whose axis points down, and wheel joints whose positive direction rolls the wheel backward.
    Use a Multiply node to multiply the command of each joint by 1 or -1. If only some wheels are driven, select their speeds with
    an ArraySlice node.

    A limit of 0 means no limit. The sign of a wired limit, length, acceleration or rate of change is ignored. Changed inputs
    take effect at the next execution.
    """

    exec_in = ExecIn()
    acceleration: float = In(default=0.0, ge=0.0, unit="m/s2", doc="acceleration towards `speed`; 0: at once")
    max_acceleration: float = In(default=0.0, ge=0.0, unit="m/s2", doc="upper limit of `acceleration`; 0: no limit")
    speed: float = In(default=0.0, unit="m/s", doc="forward speed at the middle of the unsteered axle")
    steering_angle: float = In(
        default=0.0, unit="rad", doc="steering angle of a bicycle with this wheel base; left is positive"
    )
    max_wheel_rotation: float = In(default=6.28, ge=0.0, unit="rad", doc="largest steering angle of a wheel; 0: none")
    steering_angle_velocity: float = In(
        default=0.0, ge=0.0, unit="rad/s", doc="rate of change towards `steeringAngle`; 0: at once"
    )
    max_steering_angle_velocity: float = In(
        default=0.0, ge=0.0, unit="rad/s", doc="limit of `steeringAngleVelocity`; 0: no limit"
    )
    wheel_base: float = In(gt=0.0, required=True, unit="m", doc="distance between the axles")
    track_width: float = In(
        default=0.0,
        ge=0.0,
        required=True,
        default_counts=True,
        unit="m",
        doc="distance between left and right wheels; 0: each axle is treated as a single wheel in its middle",
    )
    front_wheel_radius: float = In(
        default=0.0, ge=0.0, required="radius", unit="m", doc="radius of the front wheels; 0: same as `backWheelRadius`"
    )
    back_wheel_radius: float = In(
        default=0.0, ge=0.0, required="radius", unit="m", doc="radius of the back wheels; 0: same as `frontWheelRadius`"
    )
    max_wheel_velocity: float = In(default=0.0, ge=0.0, unit="rad/s", doc="largest speed of a wheel; 0: no limit")
    invert_steering: bool = In(
        default=False, doc="true: the back wheels steer, in the opposite direction; false: the front wheels"
    )
    dt: float = In(
        default=0.0, ge=0.0, unit="s", doc="time between two executions; needed for ramps of speed and steering"
    )
    exec_out = ExecOut()
    wheel_angles: Doubles = Out(unit="rad", doc="angles of the steered wheels: [left, right]")
    wheel_rotation_velocity: Doubles = Out(unit="rad/s", doc="speeds: [front left, front right, back left, back right]")

    previous_speed: float = State(default=0.0)
    previous_angle: float = State(default=0.0)

    def compute(self) -> None:
        """Apply limits and ramps to the command, then compute and output the angles and speeds of the wheels.

        Raises:
            BadValueError: the wheel base or both radii are 0, a ramp needs `dt` but `dt` is 0, or a number is not finite.
        """
        base, half_track, front, back = self.geometry()
        fastest, widest = abs(self.max_wheel_velocity), abs(self.max_wheel_rotation)
        speed, angle = self.commanded(fastest * max(front, back), widest)
        check_outcome(self, speed, angle)
        slope = math.tan(angle)
        left, right = 1.0 - half_track / base * slope, 1.0 + half_track / base * slope
        # Where the turning centre lies between the wheels, the share of one is negative, and it rolls backwards.
        steered = math.copysign(math.hypot(left, slope), left), math.copysign(math.hypot(right, slope), right)
        if self.invert_steering:
            shares = (left / front, right / front, steered[0] / back, steered[1] / back)
            slope = -slope
        else:
            shares = (steered[0] / front, steered[1] / front, left / back, right / back)
        turned = [math.atan2(math.copysign(1.0, side) * slope, abs(side)) for side in (left, right)]
        angles = [limited(side, widest) for side in turned]
        speeds = [limited(speed * share, fastest) for share in shares]
        check_outcome(self, *angles, *speeds)
        self.previous_speed, self.previous_angle = speed, angle
        self.wheel_angles, self.wheel_rotation_velocity = np.array(angles), np.array(speeds)

    def geometry(self) -> tuple[float, float, float, float]:
        """Return the wheel base, half the track width, the front wheel radius and the back wheel radius, m; none is negative.

        Raises:
            BadValueError: the wheel base or both radii are 0.
        """
        front, back = abs(self.front_wheel_radius), abs(self.back_wheel_radius)
        if self.wheel_base == 0.0:
            raise BadValueError("wheelBase", self.wheel_base, "other than 0")
        if not (front or back):
            legal = "two numbers, at least one of them not 0"
            raise BadValueError("frontWheelRadius, backWheelRadius", (front, back), legal)
        return abs(self.wheel_base), abs(self.track_width) / 2.0, front or back, back or front

    def commanded(self, fastest: float, widest: float) -> tuple[float, float]:
        """Return the speed (m/s) and the steering angle (rad) to use in this execution, after limits and ramps.

        Args:
            fastest: limit of the speed, m/s; 0 means no limit.
            widest: limit of the steering angle, rad; 0 means no limit.

        Raises:
            BadValueError: a ramp needs `dt`, but `dt` is 0.
        """
        acceleration = limited(abs(self.acceleration), abs(self.max_acceleration))
        turning = limited(abs(self.steering_angle_velocity), abs(self.max_steering_angle_velocity))
        if self.dt == 0.0 and (acceleration or turning):
            ports = "dt, acceleration, steeringAngleVelocity"
            raise BadValueError(ports, self.dt, "above 0 for ramps (wire deltaSeconds of OnPlaybackTick to dt)")
        speed, angle = limited(self.speed, fastest), limited(self.steering_angle, widest)
        dt = abs(self.dt)
        return ramped(self.previous_speed, speed, acceleration, dt), ramped(self.previous_angle, angle, turning, dt)


LENGTHS[AckermannController] = lambda _, output: 2 if output == "wheel_angles" else 4
