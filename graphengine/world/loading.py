"""From a scene file to one compiled model, its stage and its simulation."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from graphengine.diagnostics import Findings, PhysicsError
from graphengine.files import Files
from graphengine.spec import SceneSpec
from graphengine.spec_reader import Loaded
from graphengine.stage import PHYSICS_SCENE, Stage
from graphengine.world.files.references import Library
from graphengine.world.model.fleet import placements
from graphengine.world.model.prims import add_robot
from graphengine.world.model.robot import Robot
from graphengine.world.model.scenery import Scenery, body_names
from graphengine.world.model.world_model import world_spec
from graphengine.world.model.world_prims import add_world
from graphengine.world.physics.force_limits import tell_limits
from graphengine.world.sensors.rays import RaysChoice
from graphengine.world.simulation import Simulation

SLOWEST = 0.1
"""Ticks a second below which a step is too long for any physics."""


@dataclass(frozen=True, slots=True)
class LoadedWorld:
    """A scene that compiled.

    Attributes:
        simulation: physics and sensors, a `backend.World`.
        stage: prims of robots and of the world; graphs are not among them.
        robots: by name, in order of the scene file.
        scenery: what the model was compiled from, for whoever adds a robot or takes one away.
    """

    simulation: Simulation
    stage: Stage
    robots: dict[str, Robot]
    scenery: Scenery


def load_world(
    scene: Loaded[SceneSpec], files: Files, findings: Findings, *, seed: int = 0, rays: RaysChoice = "auto"
) -> LoadedWorld | None:
    """Build a scene's physics; what is wrong goes to `findings`, and then None comes back.

    Args:
        scene: read and checked; relative paths begin in its folder.
        files: where references may lead.
        findings: takes errors, the lint of the timestep and notes on what was resolved.
        seed: of the sensors' noise.
        rays: what lidars see with.
    """
    before = len(findings.errors)
    if scene.spec.physics.tick_rate < SLOWEST:
        span = scene.document.span("physics", "tick_rate")
        findings.add("G109", f"tick_rate: physics needs at least {SLOWEST} ticks a second", span)
        return None
    library = Library(files, findings)
    scenery = Scenery(scene, *world_spec(scene, library, findings), library)
    robots: dict[str, Robot] = {}
    for placement in placements(scene, findings):
        robot = scenery.robot(placement, findings)
        if robot is not None:
            robots[placement.name] = robot
    if len(findings.errors) > before:
        return None
    model = scenery.compile(robots, findings)
    if model is None:
        return None
    stage = Stage()
    add_world(stage, model, robots)
    bodies = body_names(model)
    for robot in robots.values():
        add_robot(stage, robot, bodies, findings)
    if PHYSICS_SCENE not in stage:  # a robot may have that name
        stage.add(PHYSICS_SCENE, "scope")
    if len(findings.errors) > before:
        return None
    physics, settle = scene.spec.physics, scene.spec.settle
    rate = Fraction(repr(physics.tick_rate))
    try:
        simulation = Simulation(model, stage, rate, physics.substeps, seed=seed, settle=settle, rays=rays)
    except PhysicsError as error:
        message, *remedy = str(error).split("\n")
        findings.add("S106", message, scene.document.key_span("settle" if settle else "world"), *remedy)
        return None
    tell_limits(simulation.limits, robots, findings)
    if settle and simulation.settled_after is None:
        findings.add("N103", "not at rest after 5 s; t = 0 begins as it is", scene.document.key_span("settle"))
    return LoadedWorld(simulation, stage, robots, scenery)
