"""Look-alikes of wheeled bases: descriptions and robot files from a few numbers, and how they move."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import unrotate
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Wheel:
    """A wheel at (x, y), m.

    `heading` (rad) turns the axle from the y axis of the base; `steering` is the sign of the steering axis, 0 without one.
    """

    name: str
    x: float
    y: float
    heading: float = 0.0
    steering: int = 0


@dataclass(frozen=True)
class Base:
    """A chassis on wheels.

    Attributes:
        name: of the robot, and of its files.
        wheels: all of the same size.
        radius: of the wheels, m.
        width: of the wheels, m.
        mass: of the chassis, kg.
        driven: names of the wheels with a drive; empty: all.
        centre: centre of mass of the chassis (x, y), m.
    """

    name: str
    wheels: tuple[Wheel, ...]
    radius: float
    width: float
    mass: float
    driven: tuple[str, ...] = ()
    centre: tuple[float, float] = (0.0, 0.0)

    def urdf(self) -> str:
        """The description; base_link is on the level of the axles."""
        size = 0.9 * max(abs(wheel.x) for wheel in self.wheels) + 0.1
        inertia = self.mass * size**2 / 3
        chassis = _inertial(self.mass, inertia, inertia, 1.5 * inertia, self.centre)
        parts = [f'<link name="base_link">{chassis}</link>']
        for wheel in self.wheels:
            parts += self._wheel(wheel)
        return f'<robot name="{self.name}">{"".join(parts)}</robot>'

    def _wheel(self, wheel: Wheel) -> list[str]:
        parts, above, place = [], "base_link", f'xyz="{wheel.x} {wheel.y} 0" rpy="0 0 {wheel.heading}"'
        if wheel.steering:
            above = f"{wheel.name}_knuckle"
            parts.append(f'<link name="{above}">{_inertial(0.5, 0.005, 0.005, 0.005)}</link>')
            parts.append(_joint(f"{wheel.name}_steer", "base_link", above, place, f"0 0 {wheel.steering}"))
            place = 'xyz="0 0 0"'
        mass = 0.05 * self.mass
        about, across = mass * self.radius**2 / 2, mass * (3 * self.radius**2 + self.width**2) / 12
        shape = f'<cylinder radius="{self.radius}" length="{self.width}"/>'
        collider = f'<collision><origin rpy="1.5707963267948966 0 0"/><geometry>{shape}</geometry></collision>'
        parts.append(f'<link name="{wheel.name}">{_inertial(mass, across, about, across)}{collider}</link>')
        return [*parts, _joint(f"{wheel.name}_joint", above, wheel.name, place, "0 1 0")]

    def files(self, keys: str = "", damping: float = 50.0, name: str = "bot") -> dict[str, str]:
        """The robot file and the description by their names; `keys` are more of the robot file."""
        driven = self.driven or [wheel.name for wheel in self.wheels]
        steered = [wheel.name for wheel in self.wheels if wheel.steering]
        drives = "".join(f"  {wheel}_joint: {{drive: {{damping: {damping}}}}}\n" for wheel in driven)
        drives += "".join(f"  {wheel}_steer: {{drive: {{stiffness: 2000, damping: 50}}}}\n" for wheel in steered)
        colliders = ", ".join(f"{wheel.name}: ellipsoid" for wheel in self.wheels)
        text = f"robot: {name}\nurdf: {name}.urdf\nwheel_colliders: {{{colliders}}}\njoints:\n{drives}{keys}\n"
        return {f"{name}.urdf": self.urdf(), f"{name}.yaml": text}

    def write(self, project: Project, keys: str = "", damping: float = 50.0, name: str = "bot") -> Project:
        """Write the robot's two files."""
        for file, text in self.files(keys, damping, name).items():
            project.write(file, text)
        return project


def material(wheels: Sequence[str], direction: Sequence[float], across: float, more: str = "") -> str:
    """A material of 0.8 along a direction for some wheels, one line of a robot file's `materials`."""
    bind = ", ".join(wheels)
    given = f"across: {across}, direction: {list(direction)}"
    return f"  {wheels[0]}: {{dynamic_friction: 0.8, {given}, bind: [{bind}]{more}}}\n"


def _inertial(mass: float, x: float, y: float, z: float, centre: tuple[float, float] = (0.0, 0.0)) -> str:
    inertia = f'<inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/>'
    return f'<inertial><origin xyz="{centre[0]} {centre[1]} 0"/><mass value="{mass}"/>{inertia}</inertial>'


def _joint(name: str, parent: str, child: str, place: str, axis: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin {place}/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="continuous">{ends}</joint>'


FOUR = ("front_left", "front_right", "rear_left", "rear_right")


def four_wheels(base: float, track: float) -> tuple[Wheel, ...]:
    """Wheels at the corners of a rectangle."""
    places = [(x, y) for x in (base / 2, -base / 2) for y in (track / 2, -track / 2)]
    return tuple(Wheel(name, x, y) for name, (x, y) in zip(FOUR, places, strict=True))


SKID = Base("skid", four_wheels(0.512, 0.5708), 0.1651, 0.1143, 46.0)
MECANUM = Base("mecanum", four_wheels(0.3, 0.4208), 0.05, 0.04, 13.0)


def twist(simulation: Simulation, robot: str = "bot") -> Floats:
    """Velocity ahead and to the left (m/s) and turn rate (rad/s) of base_link, in its own frame."""
    body = simulation.body(simulation.stage.find(f"/{robot}/base_link"))
    orientation, (linear, angular) = body.pose()[1], body.velocity()
    return np.array([*unrotate(orientation, linear)[:2], unrotate(orientation, angular)[2]])


def reached(
    simulation: Simulation, command: Callable[[float], Any], seconds: float = 3.0, robot: str = "bot"
) -> Floats:
    """The mean twist over the last third of a run; the command is scaled from 0 to 1 in the first third."""
    steps, seen = round(seconds / simulation.model.opt.timestep), []
    for step in range(steps):
        if step % simulation.substeps == 0:
            command(min(1.0, 3 * step / steps))
        simulation.step()
        if step >= 2 * steps // 3:
            seen.append(twist(simulation, robot))
    mean: Floats = np.mean(seen, axis=0)
    return mean


def joints(simulation: Simulation, robot: str = "bot") -> Joints:
    """The joints of a robot."""
    return simulation.articulation(simulation.stage.find(f"/{robot}"))


ROLLERS = dict(zip(FOUR, (-1, 1, 1, -1), strict=True))
"""Of a mecanum base: the axis of the roller at the floor points along (1, s)."""
MECANUM_WHEELS = "materials:\n" + "".join(material([name], (1, sign, 0), 0.0) for name, sign in ROLLERS.items())
SKID_WHEELS = "materials:\n" + material(FOUR, (1, 0, 0), 0.05)
ON_THE_FLOOR = "scene: test\nworld: world.xml\nrobots:\n  bot: {{use: bot.yaml, position: [0, 0, {height}]}}\n"
