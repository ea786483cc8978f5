"""The joints of a robot, its contacts and its speed, as the explanation of a standing robot needs them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from graphengine.devices.backend import World
from graphengine.devices.stage import Prim

STILL_BASE = 0.01
"""Speed below which a robot stands, m/s and rad/s."""
STILL_SHARE = 0.3
"""Share of the commanded speed of its wheels below which a robot stands: one that pushes against a wall trembles."""
STILL_JOINT = 0.02
"""Speed below which a joint stands, rad/s or m/s."""
REACHED = 0.01
"""Distance from its target at which the drive of a joint has reached its position, rad or m."""
SIDEWAYS = 0.7
"""Smallest horizontal part of a contact's unit normal with which the contact counts as an obstacle rather than as support."""
CLOSE = 0.05
"""Distance up to which a body counts as the obstacle of a robot that bounces off it, m."""


@dataclass(frozen=True, slots=True)
class JointMotion:
    """One movable joint: its drive and targets, and its present motion; rad or m, and N m or N.

    Attributes:
        target_position: target of the position drive; None without one.
        target_velocity: target of the velocity drive; None without one.
        max_effort: largest effort of the drive; infinite without a limit.
    """

    name: str
    position: float
    velocity: float
    effort: float
    target_position: float | None
    target_velocity: float | None
    stiffness: float
    max_effort: float
    range: tuple[float, float]
    prismatic: bool

    @property
    def is_commanded(self) -> bool:
        """Whether a target of the drive differs from the joint's present state of rest."""
        away = self.target_position is not None and abs(self.target_position - self.position) > REACHED
        turns = self.target_velocity is not None and abs(self.target_velocity) > 1e-9
        return turns or (away and self.stiffness > 0.0)

    @property
    def moves(self) -> bool:
        """Whether the joint moves."""
        return abs(self.velocity) > STILL_JOINT

    @property
    def at_limit(self) -> bool:
        """Whether the joint is at an end of its range."""
        return min(abs(self.position - end) for end in self.range) < REACHED / 2

    def __str__(self) -> str:
        rate, unit = ("m/s", "m") if self.prismatic else ("rad/s", "rad")
        effort = f"effort {self.effort:z.3f} {'N' if self.prismatic else 'N m'}"
        state = f"{self.name}: at {self.position:z.3f} {unit}, moves at {self.velocity:z.3f} {rate}, {effort}"
        if self.target_position is not None and self.stiffness:
            state += f"; target {self.target_position:z.3f} {unit} with stiffness {self.stiffness:.4g}"
        if self.target_velocity is not None:
            state += f"; target {self.target_velocity:z.3f} {rate}"
        return state


@dataclass(frozen=True, slots=True)
class RobotMotion:
    """The motion of a robot after the last tick.

    Attributes:
        speed: horizontal speed of the base link, m/s.
        turn: turn rate of the base link about the vertical axis, rad/s.
        joints: all movable joints.
        wheels: radius of each wheel by the name of its joint, m.
        supports: number of contact points between the wheels and other bodies.
        obstacles: horizontal force (N) between the robot and each body that does not support it, by the body's name.
    """

    speed: float
    turn: float
    joints: Sequence[JointMotion]
    wheels: Mapping[str, float]
    supports: int
    obstacles: dict[str, float]

    @property
    def base_moves(self) -> bool:
        """Whether the base moves, faster than a robot trembles that pushes against a wall."""
        rims = [abs(joint.target_velocity or 0.0) * self.wheels.get(joint.name, 0.0) for joint in self.joints]
        return max(self.speed, self.turn) > max(STILL_BASE, STILL_SHARE * max(rims, default=0.0))

    @property
    def stands(self) -> bool:
        """Whether neither the base nor a joint moves; the joints of wheels do not count."""
        return not (self.base_moves or any(joint.moves for joint in self.joints if joint.name not in self.wheels))


def read_motion(world: World, robot: Prim) -> RobotMotion:
    """Return the motion of a robot after the last tick."""
    state, wheels = world.entities.state(robot.entity_name), robot.facts.get("wheel_radii", {})
    supports, obstacles = _contacts(world, robot, wheels)
    speed, turn = math.hypot(*state.linear_velocity[:2]), abs(state.angular_velocity[2])
    return RobotMotion(speed, turn, _joints(world, robot), wheels, supports, obstacles)


def _joints(world: World, robot: Prim) -> list[JointMotion]:
    articulation = world.articulation(robot)
    facts = {prim.facts["joint"]: prim.facts for prim in robot.descendants() if prim.kind == "joint"}
    set_points = zip(*articulation.set_points(), strict=True)
    states = zip(articulation.positions(), articulation.velocities(), articulation.efforts(), set_points, strict=True)
    joints = []
    for index, (position, velocity, effort, targets) in enumerate(states):
        name = articulation.joint_names[index]
        drive, limit = facts[name].get("drive"), facts[name].get("effort") or math.inf
        placed, turned = (None if math.isnan(target) else float(target) for target in targets)
        joints.append(
            JointMotion(
                name,
                float(position),
                float(velocity),
                float(effort),
                placed,
                turned,
                float(articulation.stiffness[index]),
                min(limit, getattr(drive, "max_force", math.inf) or math.inf),
                articulation.ranges[index],
                articulation.prismatic[index],
            )
        )
    return joints


def _contacts(world: World, robot: Prim, wheels: Collection[str]) -> tuple[int, dict[str, float]]:
    """Return the number of contact points of the wheels, and the horizontal forces of the robot's other contacts."""
    names, contacts = world.bodies().names, world.contacts()
    own = {prim.body for prim in robot.descendants() if prim.body is not None}
    rolling = set[str | None]()
    for joint in (prim for prim in robot.descendants() if prim.kind == "joint" and prim.facts["joint"] in wheels):
        child = world.stage.find(joint.facts["child"])
        rolling |= {child.carrier()[0]} | {prim.body for prim in child.descendants()}
    supports, obstacles = 0, dict[str, float]()
    for (first, second), force, normal in zip(contacts.bodies, contacts.forces, contacts.normals, strict=True):
        pair = names[first], names[second]
        inside = [name for name in pair if name in own]
        if len(inside) != 1:
            continue
        supports += inside[0] in rolling
        if math.hypot(*normal[:2]) > SIDEWAYS:
            other = pair[1 - pair.index(inside[0])]
            obstacles[other] = obstacles.get(other, 0.0) + math.hypot(*force[:2])
    return supports, obstacles
