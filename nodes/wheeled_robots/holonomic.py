"""The controller of bases with omnidirectional or mecanum wheels."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from graphengine.devices import rotation
from graphengine.devices.rotation import Vector3
from graphengine.node import BadValueError, Double3, Double3s, Double4s, Doubles, ExecIn, In, Node, Out, State
from graphengine.nodes.checked import check_finite, check_outcome
from graphengine.nodes.known_inputs import LENGTHS
from graphengine.nodes.wheeled_robots.limits import limited


class HolonomicController(Node, type="isaacsim.robot.wheeled_robots.HolonomicController"):
    """Computes the wheel speeds of a base with omnidirectional or mecanum wheels from the twist of the base.

    A wheel has the speed s, the radius r, the position p, the axle a and the roller axis g. The unit vector g is the axle rotated
    by the wheel's `mecanumAngles` about `upAxis`. The base has the velocity v and the turn rate w.

    If `rolling` is false, the node uses Isaac Sim's model: each wheel contributes s r g to the velocity and s r (g x p) to the
    turn rate of the base. Among all wheel speeds whose contributions add up to the twist, the node outputs the speeds
    with the least sum of r s^2. This model ignores that wheels roll.

    If `rolling` is true, the wheels roll on the floor and do not slip along their roller axes. For each wheel,
    s r (a x up) . g = (v + w up x p) . g, where `up` is the unit vector along `upAxis`.

    A limit of 0 means no limit; the sign of a wired limit is ignored. Changed inputs take effect at the next execution.
    """

    exec_in = ExecIn()
    wheel_radius: Doubles = In(gt=0.0, required=True, unit="m", doc="radii: one per wheel, or one for all wheels")
    wheel_positions: Double3s = In(required=True, unit="m", doc="position of each wheel relative to the base's centre")
    wheel_orientations: Double4s = In(required=True, doc="orientation (w, x, y, z) of each wheel relative to the base")
    mecanum_angles: Doubles = In(
        required=True, unit="deg", doc="angles from axle to roller axis about `upAxis`: one per wheel, or one for all"
    )
    wheel_axis: Double3 = In(default=(1.0, 0.0, 0.0), doc="direction of the axle in the frame of each wheel")
    up_axis: Double3 = In(default=(0.0, 0.0, 1.0), doc="up direction in the frame of the base")
    input_velocity: Double3 = In(
        default=(0.0, 0.0, 0.0),
        unit="m/s, m/s, rad/s",
        doc="twist: [forward speed, speed to the left, counter-clockwise turn rate]",
    )
    max_linear_speed: float = In(default=100000.0, ge=0.0, unit="m/s", doc="largest speed of the base; 0: no limit")
    max_angular_speed: float = In(default=100000.0, ge=0.0, unit="rad/s", doc="largest turn rate; 0: no limit")
    max_wheel_speed: float = In(
        default=100000.0,
        ge=0.0,
        unit="rad/s",
        doc="largest speed of a wheel; if a wheel exceeds this speed, all wheel speeds are scaled down; 0: no limit",
    )
    linear_gain: float = In(default=1.0, doc="factor for both speeds in `inputVelocity`")
    angular_gain: float = In(default=1.0, doc="factor for the turn rate in `inputVelocity`")
    rolling: bool = In(
        default=False,
        extension=True,
        doc="true: wheels do not slip along their roller axes; false: Isaac Sim's model, which ignores that wheels roll",
    )
    joint_velocity_command: Doubles = Out(unit="rad/s", doc="speed of each wheel, in the order of `wheelPositions`")

    matrix: Doubles | None = State(default=None)
    matrix_of: tuple[object, ...] = State(default=())

    def compute(self) -> None:
        """Apply the limits to the twist, then compute and output the wheel speeds.

        Raises:
            BadValueError: the wheels cannot drive the base in every direction, a number is not finite, or arrays for the wheels
                differ in length.
        """
        matrix, geometry = self.matrix, self.geometry()
        if matrix is None or any(one is not other for one, other in zip(geometry, self.matrix_of, strict=True)):
            with np.errstate(all="ignore"):
                matrix = self.wheel_speeds_of_a_twist()
        forward, sideways = self.input_velocity[0] * self.linear_gain, self.input_velocity[1] * self.linear_gain
        speed = math.hypot(forward, sideways)
        share = limited(speed, abs(self.max_linear_speed)) / speed if speed else 1.0
        turning = limited(self.input_velocity[2] * self.angular_gain, abs(self.max_angular_speed))
        check_outcome(self, forward * share, sideways * share, turning)
        with np.errstate(all="ignore"):
            command: Doubles = matrix @ (forward * share, sideways * share, turning)
            fastest = float(np.abs(command).max())
            if fastest:
                command *= limited(fastest, abs(self.max_wheel_speed)) / fastest
        check_outcome(self, *command.tolist())
        self.matrix, self.matrix_of, self.joint_velocity_command = matrix, geometry, command

    def geometry(self) -> tuple[object, ...]:
        """Return the inputs that determine the matrix of `wheel_speeds_of_a_twist`; if they are unchanged, so is the matrix."""
        arrays = (self.wheel_radius, self.wheel_positions, self.wheel_orientations, self.mecanum_angles)
        return (*arrays, self.wheel_axis, self.up_axis, self.rolling)

    def wheel_speeds_of_a_twist(self) -> Doubles:
        """Return the matrix (wheels, 3) that maps a twist (forward speed, speed to the left, turn rate) to wheel speeds.

        Raises:
            BadValueError: the wheels cannot drive the base in every direction, a number is not finite, or arrays for the wheels
                differ in length.
        """
        # LAPACK would print an error about numbers that are not finite.
        arrays = "wheel_radius", "wheel_positions", "wheel_orientations", "mecanum_angles"
        check_finite(self, *arrays, "wheel_axis", "up_axis")
        wheels, positions = len(self.wheel_positions), self.wheel_positions
        if wheels < 3:
            raise BadValueError("wheelPositions", positions, "the positions of 3 or more wheels")
        radii = self.per_wheel("wheelRadius", self.wheel_radius)[:, None]
        if not np.all(radii > 0.0):
            raise BadValueError("wheelRadius", self.wheel_radius, "above 0")
        axles, rollers = (np.array(axes) for axes in zip(*self.axes(), strict=True))
        contributions: Doubles = radii * rollers
        contributions[:, 2] = np.cross(contributions, positions)[:, 2]
        if not np.isfinite(contributions).all() or np.linalg.matrix_rank(contributions) < 3:
            raise _cannot_drive(positions)
        if self.rolling:
            return _without_slip(radii, axles, rollers, positions, np.array(_unit("upAxis", self.up_axis)))
        weighted = contributions / radii
        try:
            least: Doubles = weighted @ np.linalg.inv(contributions.T @ weighted)
        except np.linalg.LinAlgError:
            raise _cannot_drive(positions) from None
        return least

    def axes(self) -> Iterator[tuple[Vector3, Vector3]]:
        """Yield the axle and the roller axis of each wheel, as unit vectors in the frame of the base.

        Raises:
            BadValueError: there is not one orientation per wheel, there is neither one angle nor one angle per wheel, or a
                vector or quaternion has the length 0.
        """
        angles = self.per_wheel("mecanumAngles", self.mecanum_angles).tolist()
        orientations = self.wheel_orientations.tolist()
        if len(orientations) != len(angles):
            lengths, legal = [len(orientations), len(angles)], "of equal length, one orientation for each position"
            raise BadValueError("wheelOrientations, wheelPositions", lengths, legal)
        up = _unit("upAxis", self.up_axis)
        for angle, orientation in zip(angles, orientations, strict=True):
            w, x, y, z = _unit("wheelOrientations", orientation)
            a, b, c = _unit("wheelAxis", self.wheel_axis)
            axle = rotation.rotate((x, y, z, w), (a, b, c))
            half = math.radians(angle) / 2
            i, j, k = (part * math.sin(half) for part in up)
            yield axle, rotation.rotate((i, j, k, math.cos(half)), axle)

    def per_wheel(self, name: str, values: Doubles) -> Doubles:
        """Return one value per wheel; a single value is repeated for all wheels.

        Args:
            name: OmniGraph name of the input, for the error message.
            values: value of the input.

        Raises:
            BadValueError: the number of values is neither 1 nor the number of wheels.
        """
        wheels = len(self.wheel_positions)
        if len(values) not in (1, wheels):
            legal = f"of equal length, or {name} of length 1 for all wheels"
            raise BadValueError(f"{name}, wheelPositions", [len(values), wheels], legal)
        return np.broadcast_to(values, wheels)


LENGTHS[HolonomicController] = lambda inputs, _: inputs.length("wheel_positions")


def _cannot_drive(positions: Doubles) -> BadValueError:
    ports = "wheelPositions, wheelRadius, wheelOrientations, mecanumAngles, wheelAxis, upAxis"
    return BadValueError(ports, positions, "the geometry of wheels that together drive the base in every direction")


def _without_slip(radii: Doubles, axles: Doubles, rollers: Doubles, positions: Doubles, up: Doubles) -> Doubles:
    """Return the matrix (wheels, 3) that maps a twist to the speeds of wheels that do not slip along their roller axes.

    Args:
        radii: radius of each wheel, m, shape (wheels, 1).
        axles: unit vectors of the axles, shape (wheels, 3).
        rollers: unit vectors of the roller axes, shape (wheels, 3).
        positions: positions of the wheels, m, shape (wheels, 3).
        up: unit vector that points up.

    Raises:
        BadValueError: a roller axis has the direction of its wheel's axle: the wheel does not drive.
    """
    grips = radii * np.sum(np.cross(axles, up) * rollers, axis=1, keepdims=True)
    if np.any(np.abs(grips) < 1e-9 * radii):
        legal = "such that no roller axis is parallel to the axle"
        raise BadValueError("mecanumAngles, upAxis, wheelAxis", grips.tolist(), legal)
    paths = np.column_stack([rollers[:, :2], np.cross(positions, rollers) @ up])
    speeds: Doubles = paths / grips
    return speeds


def _unit(name: str, vector: Iterable[float]) -> list[float]:
    """Return a vector or quaternion divided by its length.

    Args:
        name: OmniGraph name of the input, for the error message.
        vector: components of the vector or quaternion.

    Raises:
        BadValueError: the length is 0, infinite or NaN.
    """
    parts = list(vector)
    length = math.hypot(*parts)
    if not 0.0 < length < math.inf:
        raise BadValueError(name, vector, "of a finite length above 0")
    return [part / length for part in parts]
