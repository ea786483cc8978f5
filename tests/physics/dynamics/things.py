"""A world of a few things, which tests of entities have in common."""

from __future__ import annotations

from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project, steps

BALL = '<body name="ball" pos="5 0 1"><freejoint/><geom size=".1" mass="2"/></body>'
SHELF = '<body name="shelf" pos="1 2 3"><geom type="box" size=".1 .2 .3"/></body>'
DOOR = '<body name="door" pos="8 0 1"><joint name="hinge" axis="0 0 1"/><geom type="box" pos=".4 0 0" size=".4 .05 .9"/></body>'
SPACE = '<option gravity="0 0 0"/>'
IMU = "sensors: {unit: {type: imu, profile: imu, parent: base_link, position: [0, 0, 0.3]}}\n"


def world(project: Project, *bodies: str, options: str = "") -> LoadedWorld:
    return project.world(*bodies, before=options).load()


def bounds(simulation: Simulation, name: str, *, own: bool = False) -> tuple[float, ...]:
    """The lower and the upper corner of an entity's box."""
    box = simulation.entities.bounds(name, own=own)
    assert box is not None
    return (*box.low, *box.high)


def run(simulation: Simulation, seconds: float) -> None:
    steps(simulation, round(seconds / simulation.model.opt.timestep))


def add(loaded: LoadedWorld, name: str, x: float = -4.0) -> None:
    loaded.add(name, RobotUse(use="bot.yaml", position=(x, 0.0, 0.1)))
