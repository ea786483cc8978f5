"""Builds the physics of a scene file: the compiled model, its stage and its simulation."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from fractions import Fraction
from pathlib import Path

from graphengine.descriptions.earth import earth_of
from graphengine.descriptions.engine import body_names
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.robot_files.robot_file import read_robot
from graphengine.devices.entity import MOST_TOLD, Overlap
from graphengine.devices.stage import PHYSICS_SCENE, Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import PhysicsError
from graphengine.format.files import Files
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec import RobotUse
from graphengine.format.spec_reader import Loaded
from graphengine.physics.dynamics.force_limits import tell_limits
from graphengine.physics.dynamics.settling import SETTLED_SPEED
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.model.fleet_expansion import place, placements
from graphengine.physics.model.mesh_units import check_mesh_units
from graphengine.physics.model.robot import RobotInstance, load_robot
from graphengine.physics.model.robot_prims import add_robot
from graphengine.physics.model.scenery import Scenery
from graphengine.physics.model.world_model import world_spec
from graphengine.physics.model.world_prims import add_world
from graphengine.physics.ray_casting.rays import RaysChoice
from graphengine.physics.simulation import Simulation

_FREE_PATH = "choose a path with no prim at or below it, and with only scopes above it"
SLOWEST = 0.1
"""Lowest tick rate, ticks per second; at a lower rate, physics steps would be too long."""


def load_robot_file(path: Path, files: Files, findings: Findings) -> RobotInstance | None:
    """Load a robot file without a scene and its overrides; return None if it has errors, which are added to `findings`."""
    file = read_robot(path, files, findings)
    (placement,) = place(path.stem, RobotUse(use=str(path)))
    return load_robot(placement, file, Library(files, findings)) if file is not None else None


def load_world(
    scene: Loaded[SceneSpec],
    files: Files,
    findings: Findings,
    *,
    seed: int = 0,
    rays: RaysChoice = "auto",
    sees_own_robots: bool = True,
) -> LoadedWorld | None:
    """Build the physics of a scene; return None if the scene has errors, which are added to `findings`.

    Args:
        scene: parsed and checked scene file; paths in it are relative to its folder.
        files: files that the scene and its descriptions may refer to.
        findings: receives errors, warnings and notes.
        seed: seed of the sensors' noise.
        rays: method of casting the rays of lidars.
        sees_own_robots: whether sensors whose robot file does not say so see their own robot.
    """
    before = len(findings.errors)
    if scene.spec.physics.tick_rate < SLOWEST:
        span = scene.document.span("physics", "tick_rate")
        findings.add("G109", f"tick_rate: physics needs at least {SLOWEST} ticks a second", span)
        return None
    library = Library(files, findings)
    scenery = Scenery(scene, *world_spec(scene, library, findings), library)
    robots: dict[str, RobotInstance] = {}
    for placement in placements(scene, findings):
        robot = scenery.robot(placement, findings)
        if robot is not None:
            robots[placement.name] = robot
    if len(findings.errors) > before:
        return None
    model = scenery.compile(robots, findings)
    if model is None:
        return None
    check_mesh_units(model, ((f"{name}/", robot) for name, robot in robots.items()), findings)
    stage = Stage()
    stage.global_tf = scene.spec.tf == "global"
    add_world(stage, model, robots)
    bodies = set(body_names(model))
    for robot in robots.values():
        taken = stage.obstacle(robot.prim_path)
        if taken is None:
            add_robot(stage, robot, bodies, findings)
        else:
            key = robot.placement.key
            named = scene.document.key_span("robots", key)
            span = scene.document.span("robots", key, "at") if robot.placement.use.at else named
            findings.add("S105", f"{robot.prim_path} is taken: {taken.path} is a {taken.kind}", span, _FREE_PATH)
    if PHYSICS_SCENE not in stage:  # a robot may have that name
        stage.add(PHYSICS_SCENE, "scope")
    if len(findings.errors) > before:
        return None
    if (receiver := next(stage.prims("navsat"), None)) is not None and earth_of(model) is None:
        text = f"{receiver.path} takes the world's origin for latitude 0, longitude 0: the world has no place on Earth"
        advice = "add to the scene, for example: spherical_coordinates: {latitude_deg: 47.38, longitude_deg: 8.54}"
        findings.add("W218", text, scene.document.key_span("world"), advice)
    physics, settle = scene.spec.physics, scene.spec.settle
    rate = Fraction(repr(physics.tick_rate))
    try:
        simulation = Simulation(
            model, stage, rate, physics.substeps, seed=seed, rays=rays, sees_own_robots=sees_own_robots
        )
        touching = simulation.entities.touching()
        if settle:
            simulation.settle()  # which may push apart what touches where the files place it
            touching = simulation.entities.touching() | touching
    except PhysicsError as error:
        message, *remedy = str(error).split("\n")
        findings.add("S106", message, scene.document.key_span("settle" if settle else "world"), *remedy)
        return None
    if not _check_movers(simulation, scene, findings):
        return None
    tell_limits(simulation.limits, robots, findings)
    _tell_touching(touching, robots, scene, findings)
    if settle and simulation.settled_after is None:
        text = "the scene is not at rest after 5 s; the run starts from the state that it has reached"
        findings.add("N103", text, scene.document.key_span("settle"), *_moving(simulation))
    return LoadedWorld(simulation, robots, scenery)


def _check_movers(simulation: Simulation, scene: Loaded[SceneSpec], findings: Findings) -> bool:
    """Warn about movers that start inside a fixed body. Add an error and return False if a region has no free points."""
    for name in simulation.movers.stuck():
        text = f"mover {name!r} finds no free straight way in its region"
        advice = "give a region with free floor, of a few times the size of the mover"
        findings.add("G109", text, scene.document.span("movers", name, "region"), advice)
    for name in sorted(simulation.movers.names - simulation.movers.stuck()):
        if overlap := simulation.entities.fixed_around(name):
            span = scene.document.key_span("movers", name)
            advice = "a mover walks through fixed bodies; give its path another first point"
            findings.add("W210", f"mover {name!r} starts in {overlap}", span, advice)
    return not simulation.movers.stuck()


def _moving(simulation: Simulation) -> Iterator[str]:
    """Yield a line for each of the first entities that did not come to rest, with the names of all that it touches."""
    for name, touched in itertools.islice(simulation.entities.moving(SETTLED_SPEED).items(), MOST_TOLD):
        yield f"{name} moves, and touches {', '.join(touched[:MOST_TOLD]) or 'nothing'}"


def _tell_touching(
    touching: Mapping[str, Overlap], robots: dict[str, RobotInstance], scene: Loaded[SceneSpec], findings: Findings
) -> None:
    """Warn about robots that touch something other than their support.

    Robots of the same key in the scene's `robots` (a fleet) share one warning.
    """
    told: dict[str, list[str]] = {}
    for name, robot in robots.items():
        if name in touching:
            told.setdefault(robot.placement.key, []).append(name)
    for key, names in told.items():
        other = touching[names[0]]
        more = f"; other robots of its fleet that touch something: {len(names) - 1}" if len(names) > 1 else ""
        text = f"{names[0]} touches {other.other} at the start, {1000 * other.depth:.3g} mm deep{more}"
        advice = "physics pushes the two apart; give the robot another position"
        findings.add("W210", text, scene.document.key_span("robots", key), advice)
