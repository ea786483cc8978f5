"""Computes rolling radius, track and wheel base of a robot from the angles of its wheels and its true motion."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from graphengine.bringup.calibration.drive_recorder import Trace
from graphengine.bringup.calibration.figures import DrivenWheel, Floats, Motion, Side
from graphengine.bringup.calibration.measuring import increments, mean
from graphengine.bringup.calibration.omni_geometry import base_motion, is_oblique, rolling_directions, rolling_radii
from graphengine.descriptions.robot_description import TURNING, track
from graphengine.descriptions.rollers import rollers_of
from graphengine.physics.model.robot import RobotInstance, wheel_shapes

SLOWEST = 0.05
"""Smallest speed at which a joint counts as turning, rad/s."""
SHARE = 0.2
"""Minimum ratio of a wheel's speed in a straight drive to the speed of the fastest driven joint."""
STEERED = 0.02
"""Minimum angle of a steering joint in an arc, rad."""


class WheelMeter:
    """Collects the rotations of driven wheels over several motions.

    Straight drive: a wheel that turns by a (rad) while the base link moves forward by d (m) has the rolling radius r = d / a.
    Turn: if the base link turns by w (rad) and moves forward by d (m) while the wheel turns by a (rad), then the wheel lies at
    y = (d - r a) / w (m), measured from the base link, positive to the left.
    """

    def __init__(self, robot: RobotInstance, joints: Sequence[str]) -> None:
        self._robot = robot
        self._names = list(joints)
        self._driven = [self._names.index(name) for name in robot.drives if name in self._names]
        self._wheels: list[int] = []
        self._radii: dict[int, list[float]] = {}
        self._offsets: dict[int, list[float]] = {}
        self._bases: list[float] = []
        self._moved: dict[str, tuple[float, Floats]] = {}
        """A dict from motions to the distance (m) or angle (rad) by which the base moved, and the angle of each joint (rad)."""
        self._straight_angles: Floats = np.zeros(len(self._names))
        self._samples: list[tuple[Floats, Floats]] = []
        """Motion of the base (forward, left, m; turn, rad) and of the joints (rad) in each test drive."""
        self._axes = robot.description.axes_in_root()
        self._on_rollers = rollers_of(robot.description).keys()

    @staticmethod
    def described_wheel_base(robot: RobotInstance) -> float | None:
        """Return the distance along x between the foremost and the rearmost wheel in the robot description, m.

        Return None if all wheels are on one axle, or without wheels.
        """
        distance = _length(robot, robot.wheel_radii)
        return distance if distance > 1e-3 else None

    @property
    def driven(self) -> list[str]:
        """Names of the joints with a drive."""
        return [self._names[index] for index in self._driven]

    @property
    def stiff(self) -> list[str]:
        """Names of the joints whose drives have stiffness, as position servos have."""
        return [name for name in self.driven if self._robot.drives[name].stiffness]

    def rates(self, trace: Trace) -> dict[str, float]:
        """Return a dict from the driven joints to their mean speeds, rad/s or m/s."""
        moved = (trace.joints[-1] - trace.joints[0]) / ((len(trace.joints) - 1) * trace.dt)
        return {self._names[index]: float(moved[index]) for index in self._driven}

    def roll(self, trace: Trace) -> bool:
        """Return whether any wheel turns. Before the first straight drive, every driven joint counts as a wheel."""
        rates = self.rates(trace)
        names = [self._names[index] for index in self._wheels or self._driven]
        return any(abs(rates[name]) > SLOWEST for name in names)

    def take(self, motion: Motion, window: Trace) -> None:
        """Add the joint angles and the true motion of a steady test drive to the data for the wheel geometry."""
        whole = increments(window.base).sum(axis=0)
        forward, _, turn = whole.tolist()
        moved = window.joints[-1] - window.joints[0]
        self._samples.append((whole, moved))
        self._moved[motion.name] = (turn if motion.kind == "turn" else forward, moved)
        if motion.kind == "straight":
            self._take_straight(window, forward, moved)
        elif motion.kind == "turn" and abs(turn) > 0.1 and self._wheels:
            if motion.name == "slow_arc_left":  # a skid-steered base has another track on the spot
                self._offsets = {}
            for index in self._wheels if not motion.name.startswith("full") else ():
                if index in self._radii and not self._is_steered(index):
                    self._offsets.setdefault(index, []).append((forward - self._radius(index) * moved[index]) / turn)
            if motion.commanded.x and not motion.name.startswith("full"):
                self._take_arc(window, forward, turn)

    def _take_straight(self, window: Trace, forward: float, moved: Floats) -> None:
        speeds = np.abs(moved[self._driven])
        fastest = float(speeds.max(initial=0.0))
        if fastest / ((len(window.joints) - 1) * window.dt) <= SLOWEST:
            return
        if not self._wheels:
            self._wheels = [index for index, one in zip(self._driven, speeds, strict=True) if one > SHARE * fastest]
        self._straight_angles = window.joints.mean(axis=0)
        for index in self._wheels:
            if moved[index] and abs(forward) > 0.01:
                self._radii.setdefault(index, []).append(forward / moved[index])

    def _take_arc(self, window: Trace, forward: float, turn: float) -> None:
        """Add a measurement of the wheel base, tan(s) d / w, in an arc.

        d is the length of the arc (m), w its angle (rad), and s the mean steering angle (rad).
        """
        angles = window.joints.mean(axis=0) - self._straight_angles
        steering = [i for i in self._driven if abs(angles[i]) > STEERED and self._may_steer(i)]
        if steering:
            cotangent = float(np.mean([1.0 / math.tan(abs(angles[i])) for i in steering]))
            self._bases.append(abs(forward / turn) / cotangent)

    def _may_steer(self, index: int) -> bool:
        name = self._names[index]
        is_wheel = index in self._wheels or name in self._robot.wheel_radii
        return not is_wheel and self._robot.description.joints[name].type != "prismatic"

    def _is_steered(self, index: int) -> bool:
        """Return whether another revolute joint carries the wheel and may steer it; prismatic joints are suspensions."""
        description = self._robot.description
        above = description.carriers(description.joints[self._names[index]].parent)
        return any(carrier.type in TURNING and carrier.name in self._names for carrier in above)

    def _radius(self, index: int) -> float:
        """Return the signed rolling radius, m: negative for a wheel whose axis points to the right."""
        return float(np.mean(self._radii[index]))

    def _offset(self, index: int) -> float:
        """Return the signed distance of a wheel from the turning centre, m: positive to the left."""
        return float(np.mean(self._offsets[index]))

    # Figures

    @property
    def wheels(self) -> tuple[DrivenWheel, ...]:
        """The driven wheels, in the order of their joints in the articulation."""
        if self.oblique:
            return tuple(DrivenWheel(self._names[index], radius) for index, radius in self._omni_radii().items())
        sides: dict[int, Side] = {index: "left" if self._offset(index) > 0.0 else "right" for index in self._offsets}
        return tuple(DrivenWheel(self._names[i], abs(self._radius(i)), sides.get(i, "")) for i in sorted(self._radii))

    @property
    def oblique(self) -> bool:
        """Whether the base rolls on omni wheels whose axles have several directions."""
        return any(is_oblique(self._axes[self._names[index]]) for index in self._turning())

    def _turning(self) -> list[int]:
        """Return the driven joints that turn in any of the test drives."""
        most = np.max([np.zeros(len(self._names)), *(np.abs(moved) for _, moved in self._samples)], axis=0)
        fastest = most[self._driven].max(initial=0.0)
        return [index for index in self._driven if most[index] > SHARE * fastest]

    def _omni_radii(self) -> dict[int, float]:
        """Return a dict from indices of omni wheels to rolling radii, m; empty if the test drives do not determine them."""
        wheels = self._turning()
        motions, angles = (np.array(rows) for rows in zip(*self._samples, strict=True))
        radii = rolling_radii(motions, angles[:, wheels], self._directions(wheels))
        return dict(zip(wheels, np.abs(radii).tolist(), strict=True)) if radii is not None else {}

    def _directions(self, wheels: Sequence[int]) -> Floats:
        return rolling_directions([self._axes[self._names[index]] for index in wheels])

    @property
    def radius(self) -> float | None:
        """Mean rolling radius, m."""
        return mean([wheel.radius for wheel in self.wheels])

    @property
    def track(self) -> float | None:
        """Effective distance between left and right wheels in slow arcs, or else in turns, m; None if one side has no wheels."""
        if self.oblique:
            return None
        offsets = [self._offset(index) for index in self._offsets]
        left, right = [y for y in offsets if y > 0.0], [y for y in offsets if y <= 0.0]
        return float(np.mean(left) - np.mean(right)) if left and right else None

    @property
    def wheel_base(self) -> float | None:
        """Distance between the axles, m, computed from the steering angles in test drives along arcs; None without arcs."""
        return mean(self._bases)

    @property
    def has_several_axles(self) -> bool:
        """Whether the unsteered driven wheels stand on several axles, as in a skid-steered base."""
        return _length(self._robot, [self._names[index] for index in self._offsets]) > 1e-3

    def slip(self, motion: Motion, *, omni: bool) -> float | None:
        """Return the slip in a test drive: 1 - true motion / motion by the wheel angles; None if the slip is unknown.

        The computed motion uses the wheel radii and positions in the robot description.

        Args:
            motion: test drive that was added by `take`.
            omni: whether the base can drive sideways.
        """
        if self.oblique:
            return self._omni_slip(motion)
        if motion.name not in self._moved or motion.kind == "sideways":
            return None
        actual, angles = self._moved[motion.name]
        paths = {
            wheel: math.copysign(self._described_radius(wheel), self._radius(wheel)) * float(angles[wheel])
            for wheel in self._radii
        }
        if not paths or any(map(math.isnan, paths.values())):
            return None
        if motion.kind == "straight":
            return 1.0 - actual / rolled if (rolled := float(np.mean(list(paths.values())))) else None
        left, right = ([paths[i] for i in self._offsets if (self._offset(i) > 0.0) is side] for side in (True, False))
        distance = self._described_track(omni=omni)
        if not (left and right and distance):
            return None
        rolled = float(np.mean(right) - np.mean(left)) / distance
        return 1.0 - actual / rolled if rolled else None

    def _omni_slip(self, motion: Motion) -> float | None:
        wheels = self._turning()
        radii: Floats = np.array([self._described_radius(index) for index in wheels])
        if motion.name not in self._moved or np.isnan(radii).any():
            return None
        places: Floats = np.array([_place(self._robot, self._names[index])[:2] for index in wheels])
        actual, angles = self._moved[motion.name]
        forward, _, turn = base_motion(angles[wheels], radii, places, self._directions(wheels)).tolist()
        computed = turn if motion.kind == "turn" else forward
        return 1.0 - actual / computed if computed and motion.kind != "sideways" else None

    def _described_radius(self, index: int) -> float:
        """Return the wheel radius in the robot description, m; NaN without a radius, or if the description models rollers."""
        if self._names[index] in self._on_rollers:
            return math.nan
        return self._robot.wheel_radii.get(self._names[index], math.nan)

    def _described_track(self, *, omni: bool) -> float | None:
        joints = [self._robot.description.joints[self._names[index]] for index in self._offsets]
        distance = track(self._robot.description.wheels(joints, wheel_shapes(self._robot.spec)))
        if distance is None or not omni:
            return distance
        return distance + _length(self._robot, [joint.name for joint in joints])

    def notes(self) -> list[str]:
        """Return a note with the reason for each of radius, slip and track that was not measured."""
        if not self._radii:
            return ["wheel radius: no driven joint turns while the robot drives straight"]
        missing = []
        if any(math.isnan(self._described_radius(index)) for index in self._radii):
            missing.append("slip: the robot description does not contain the radius of every driven wheel")
        if self.track is None and not self.oblique:
            missing.append("track: no unsteered driven wheels on both sides of the turning centre")
        return missing


def _place(robot: RobotInstance, joint: str) -> tuple[float, float, float]:
    """Return the position of a wheel's link in the frame of the root link, m."""
    return robot.description.pose_in_root(robot.description.joints[joint].child)[0]


def _length(robot: RobotInstance, joints: Iterable[str]) -> float:
    """Return the distance along x between the foremost and the rearmost of the wheels on some joints, m; 0 without joints."""
    places = [_place(robot, joint)[0] for joint in joints]
    return max(places) - min(places) if places else 0.0
