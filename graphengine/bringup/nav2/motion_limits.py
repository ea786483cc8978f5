"""Computes the motion limits of a robot from the controllers in its graphs, its wheels and its drives."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.bringup.calibration.figures import Calibration, Kind
from graphengine.bringup.calibration.robot_interface import numbers_named
from graphengine.bringup.nav2.sourced import NAV2, Sourced
from graphengine.compiler.graph import Graph, Instance
from graphengine.descriptions.engine import body_names
from graphengine.physics.model.robot import RobotInstance

Kinematics = Literal["differential", "omni", "ackermann"]

MOST_SPEED, MOST_TURN = 1.0, 1.5
"""Highest speed (m/s) and turn rate (rad/s) that Nav2 may command, for indoor driving with a costmap updated at 5 Hz."""
MOST_ACCELERATION, MOST_TURN_ACCELERATION = 2.5, 3.2
"""Linear (m/s2) and angular (rad/s2) acceleration for robots whose limits are unknown, from Nav2's own parameter file."""
GRIP = 0.5
"""Largest acceleration and deceleration by the friction of the wheels, as a share of gravity."""
FOLLOWS = 0.95
"""Share of a commanded velocity below which the robot's limits are lowered to the reached velocity."""
SHARE_OF_FORCE = 0.8
"""Share of the drives' force for the acceleration of the robot; the rest overcomes friction."""

_CONTROLLERS: dict[str, Kinematics] = {
    "isaacsim.robot.wheeled_robots.DifferentialController": "differential",
    "isaacsim.robot.wheeled_robots.HolonomicController": "omni",
    "isaacsim.robot.wheeled_robots.AckermannController": "ackermann",
}


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Motion limits of a robot, each with the source of its value.

    Attributes:
        kinematics: `differential`, `omni` or `ackermann`.
        speed: highest speed, m/s.
        turn: highest turn rate, rad/s.
        acceleration: highest acceleration, m/s2.
        deceleration: highest deceleration, m/s2.
        turn_acceleration: highest angular acceleration, rad/s2.
        turning_radius: smallest radius of a path that the base can follow, m; 0 if the robot turns on the spot.
    """

    kinematics: Sourced[Kinematics]
    speed: Sourced[float]
    turn: Sourced[float]
    acceleration: Sourced[float]
    deceleration: Sourced[float]
    turn_acceleration: Sourced[float]
    turning_radius: Sourced[float]

    @property
    def omni(self) -> bool:
        """Whether the base can drive sideways."""
        return self.kinematics.value == "omni"

    @property
    def car(self) -> bool:
        """Whether the base cannot turn on the spot."""
        return self.turning_radius.value > 0.0


def motion_limits(scene: Scene, robot: RobotInstance, graphs: Collection[str]) -> MotionLimits:
    """Return the motion limits of a robot.

    Args:
        scene: the checked scene.
        robot: a robot of the scene.
        graphs: names of the robot's graphs.
    """
    own = f"{robot.name}/"
    planned = [one for one in loaded_of(scene).planned if one.name in graphs or one.name.startswith(own)]
    inputs = partial(_inputs, planned)
    kinematics = _kinematics(planned)
    radius, base, track, steering = (
        next(iter(inputs(*names)), None)
        for names in (_RADIUS, ("wheelBase",), ("wheelDistance", "trackWidth"), ("maxWheelRotation",))
    )
    at_rim: list[Sourced[float]] = []
    if radius is not None:
        turned = inputs("maxWheelSpeed", "maxWheelVelocity")
        how = "times the wheel's radius, m/s at the rim"
        at_rim = [Sourced(one.value * radius.value, f"{one.source} {how}") for one in turned]
    at_rim += _rim_speeds(robot)
    speed = _least([*inputs("maxLinearSpeed"), *at_rim, Sourced(MOST_SPEED, "limit for indoor driving")])
    turning_radius = Sourced(0.0, "the robot turns on the spot")
    if kinematics.value == "ackermann" and base is not None:
        turning_radius = _turning_radius(base, steering, track)
    turns = [*inputs("maxAngularSpeed"), Sourced(MOST_TURN, "limit for indoor driving")]
    if turning_radius.value:
        turns.append(Sourced(speed.value / turning_radius.value, "speed divided by the turning radius"))
    elif track is not None:
        why = f"speed of the wheels divided by half the track ({track.source})"
        turns.append(Sourced(2.0 * speed.value / track.value, why))
    push = _acceleration_by_force(scene, robot)
    acceleration = _least([*inputs("maxAcceleration", "acceleration"), *push, _DEFAULT])
    deceleration = _least([*inputs("maxDeceleration"), *push, Sourced(MOST_ACCELERATION, acceleration.source)])
    lever = track.value / 2.0 if track is not None else 0.2
    by_wheels = f"acceleration of the wheels ({acceleration.source}) divided by half the track"
    bounds = [Sourced(acceleration.value / lever, by_wheels), _DEFAULT_TURN]
    turning = _least([*inputs("maxAngularAcceleration"), *bounds])
    return MotionLimits(kinematics, speed, _least(turns), acceleration, deceleration, turning, turning_radius)


def reached(limits: MotionLimits, calibration: Calibration) -> tuple[MotionLimits, list[str]]:
    """Return the limits, lowered to the velocities that the robot reaches in a calibration, and a note on each change.

    Args:
        limits: limits of the commands.
        calibration: measurements of the robot.
    """
    notes: list[str] = []

    def lowered(limit: Sourced[float], kind: Kind, name: str, unit: str) -> Sourced[float]:
        alike = [motion for motion in calibration.motions if motion.kind == kind]
        share = min((one.share for one in alike if kind != "turn" or not one.commanded.x), default=1.0)
        if not 0.0 < share < FOLLOWS:
            return limit
        notes.append(
            f"{calibration.robot} reaches {100.0 * share:.0f} % of a commanded {name}, so its limit for Nav2 is "
            f"{limit.value * share:.2f} {unit} instead of {limit.value:.2f}; `graphrun calibrate` shows which geometry is wrong"
        )
        return Sourced(limit.value * share, f"calibration: {100.0 * share:.0f} % of {limit.value:.6g} ({limit.source})")

    speed = lowered(limits.speed, "straight", "speed", "m/s")
    return replace(limits, speed=speed, turn=lowered(limits.turn, "turn", "turn rate", "rad/s")), notes


_RADIUS = ("wheelRadius", "backWheelRadius")
_DEFAULT = Sourced(MOST_ACCELERATION, f"{NAV2}; the graphs have no limit")
_DEFAULT_TURN = replace(_DEFAULT, value=MOST_TURN_ACCELERATION)


def _kinematics(graphs: Sequence[Graph]) -> Sourced[Kinematics]:
    """Return the kinematics of the first wheel controller in the graphs; differential without a controller."""
    for graph in graphs:
        for instance in graph.instances:
            if (kind := _CONTROLLERS.get(instance.cls.type_name)) is not None:
                return Sourced(kind, _place(graph, instance))
    return Sourced("differential", "assumed: the graphs have no wheel controller")


def _inputs(graphs: Sequence[Graph], *names: str) -> list[Sourced[float]]:
    """Return the nonzero magnitudes of the unwired inputs of wheel controllers with these names; 0 stands for no limit."""
    return [
        Sourced(number, f"{_place(graph, instance)}.{name}")
        for graph, instance, name, number in numbers_named(graphs, *names)
        if instance.cls.type_name in _CONTROLLERS
    ]


def _place(graph: Graph, instance: Instance) -> str:
    return f"{graph.name}/{instance.id}"


def _least(found: list[Sourced[float]]) -> Sourced[float]:
    return min(found, key=lambda one: one.value)


def _rim_speeds(robot: RobotInstance) -> Iterator[Sourced[float]]:
    """Yield the highest rim speed of each driven wheel whose drive or joint has a velocity limit, m/s."""
    joints = {joint.name: joint for joint in robot.moving}
    for name, radius in robot.wheel_radii.items():
        drive = robot.drives.get(name)
        if drive is None:
            continue
        if math.isfinite(drive.max_velocity):
            yield Sourced(drive.max_velocity * radius, f"max_velocity of the drive of {name} times the wheel's radius")
        elif (limit := joints[name].velocity) is not None:
            yield Sourced(limit * radius, f"velocity limit of {name} times the wheel's radius")


def _turning_radius(
    base: Sourced[float], steering: Sourced[float] | None, track: Sourced[float] | None
) -> Sourced[float]:
    """Return the smallest turning radius, m, of the centre of the unsteered axle.

    It is 1.1 times the radius at the steering limit; if the limit is unknown, twice the wheel base.
    """
    if steering is None or not 0.05 < steering.value < 1.3:
        return Sourced(2.0 * base.value, f"twice the wheel base ({base.source}), because the steering limit is unknown")
    inner = base.value / math.tan(steering.value)
    radius = inner + (track.value / 2.0 if track is not None else 0.0)
    return Sourced(1.1 * radius, f"wheel base, track and steering limit ({steering.source}), plus 10 % for corrections")


def _acceleration_by_force(scene: Scene, robot: RobotInstance) -> list[Sourced[float]]:
    """Return the largest accelerations by the wheel drives and by the wheels' grip, m/s2; empty if the drives have no limit."""
    wheels = {name: radius for name, radius in robot.wheel_radii.items() if name in robot.drives}
    force = sum(robot.drives[name].max_force / radius for name, radius in wheels.items())
    if not wheels or not math.isfinite(force):
        return []
    model = world_of(scene).simulation.model
    own = [name.startswith(f"{robot.name}/") for name in body_names(model)]
    mass = float(model.body_mass[own].sum())
    by_force = Sourced(SHARE_OF_FORCE * force / mass, f"max_force of {len(wheels)} drives, mass {mass:.3g} kg")
    return [by_force, Sourced(GRIP * 9.81, f"grip of the wheels: {GRIP:g} times gravity")]
