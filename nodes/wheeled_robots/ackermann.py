"""Controller of four-wheeled bases with two steered wheels."""

from __future__ import annotations

import math

import numpy as np

from graphengine.node import BadValueError, Doubles, ExecIn, ExecOut, In, Node, Out, State
from graphengine.nodes.checked import check_outcome
from graphengine.nodes.wheeled_robots.limits import limited, ramped


class AckermannController(Node, type="isaacsim.robot.wheeled_robots.AckermannController"):
    """Computes steering angles and speeds with which four wheels roll about one turning centre.

    The steering angle d is that of a bicycle with the same wheel base b. With the track width t, the turning radius of a wheel
    is the base's times k = 1 - (t / 2b) tan d on the side of the turning centre, and k = 1 + (t / 2b) tan d on the other side.
    A wheel rolls at k times `speed` and steers by atan(tan d / k). A limit of 0 is no limit. Inputs take effect whenever they
    change.
    """

    exec_in = ExecIn()
    acceleration: float = In(default=0.0, unit="m/s2", doc="acceleration towards `speed`; 0 applies `speed` at once")
    max_acceleration: float = In(default=0.0, unit="m/s2", doc="limit of `acceleration`")
    speed: float = In(default=0.0, unit="m/s", doc="forward speed at the middle of the unsteered axle")
    steering_angle: float = In(default=0.0, unit="rad", doc="steering angle d of the bicycle; left is positive")
    max_wheel_rotation: float = In(default=6.28, unit="rad", doc="limit of every steering angle")
    steering_angle_velocity: float = In(
        default=0.0, unit="rad/s", doc="rate towards `steeringAngle`; 0 applies it at once"
    )
    max_steering_angle_velocity: float = In(default=0.0, unit="rad/s", doc="limit of `steeringAngleVelocity`")
    wheel_base: float = In(default=0.0, required=True, unit="m", doc="b, distance between the axles")
    track_width: float = In(default=0.0, required=True, unit="m", doc="t, distance between left and right wheels")
    front_wheel_radius: float = In(default=0.0, required="radius", unit="m", doc="0 means equal to backWheelRadius")
    back_wheel_radius: float = In(default=0.0, required="radius", unit="m", doc="0 means equal to frontWheelRadius")
    max_wheel_velocity: float = In(default=0.0, unit="rad/s")
    invert_steering: bool = In(default=False, doc="steer with the back wheels, in the opposite direction")
    dt: float = In(default=0.0, unit="s", doc="time between two executions; needed for ramps")
    exec_out = ExecOut()
    wheel_angles: Doubles = Out(unit="rad", doc="angles of the steered wheels: [left, right]")
    wheel_rotation_velocity: Doubles = Out(unit="rad/s", doc="[front left, front right, back left, back right]")

    previous_speed: float = State(default=0.0)
    previous_angle: float = State(default=0.0)

    def compute(self) -> None:
        """Limit and ramp the command, and compute the wheels' angles and speeds.

        Raises:
            BadValueError: a length of the geometry is 0, a ramp has no dt, or a number is not finite.
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
        """Wheel base, half the track width, radius of the front and of the back wheels."""
        front, back = abs(self.front_wheel_radius), abs(self.back_wheel_radius)
        if self.wheel_base == 0.0:
            raise BadValueError("wheelBase", self.wheel_base, "other than 0")
        if not (front or back):
            raise BadValueError(
                "frontWheelRadius, backWheelRadius", (front, back), "other than 0, one of them at least"
            )
        return abs(self.wheel_base), abs(self.track_width) / 2.0, front or back, back or front

    def commanded(self, fastest: float, widest: float) -> tuple[float, float]:
        """Limited and ramped speed and steering angle of this compute."""
        acceleration = limited(abs(self.acceleration), abs(self.max_acceleration))
        turning = limited(abs(self.steering_angle_velocity), abs(self.max_steering_angle_velocity))
        if self.dt == 0.0 and (acceleration or turning):
            ports = "dt, acceleration, steeringAngleVelocity"
            raise BadValueError(ports, self.dt, "above 0 for ramps: wire deltaSeconds of OnPlaybackTick to dt")
        speed, angle = limited(self.speed, fastest), limited(self.steering_angle, widest)
        dt = abs(self.dt)
        return ramped(self.previous_speed, speed, acceleration, dt), ramped(self.previous_angle, angle, turning, dt)
