"""From a scene file to one compiled model, its stage and its simulation."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from graphengine.diagnostics import Findings, PhysicsError, Span
from graphengine.files import Files, NotFoundError
from graphengine.spec import Loaded, SceneSpec
from graphengine.stage import Stage
from graphengine.world.engine import mujoco
from graphengine.world.materials import NO_FLOOR_FRICTION
from graphengine.world.poses import from_orientation
from graphengine.world.prims import add_robot, add_world
from graphengine.world.references import Library
from graphengine.world.robot import Robot, load_robot
from graphengine.world.robot_model import robot_spec
from graphengine.world.robotfile import read_robot
from graphengine.world.simulation import Simulation
from graphengine.world.xmlfile import Element, mujoco_says, place_of, write

_DEGREE_OF_FREEDOM = re.compile(r"\bDOF (\d+)")

SLOWEST = 0.1
"""Ticks a second below which a step is too long for any physics."""


@dataclass(frozen=True, slots=True)
class LoadedWorld:
    """A scene that compiled.

    Attributes:
        simulation: physics and sensors, a `backend.World`.
        stage: prims of robots and of the world; graphs are not among them.
        robots: by name, in order of the scene file.
        editable: the MjSpec that was compiled, for whoever adds to it.
    """

    simulation: Simulation
    stage: Stage
    robots: dict[str, Robot]
    editable: mujoco.MjSpec


def load_world(scene: Loaded[SceneSpec], files: Files, findings: Findings, *, seed: int = 0) -> LoadedWorld | None:
    """Build a scene's physics; what is wrong goes to `findings`, and then None comes back.

    Args:
        scene: read and checked; relative paths begin in its folder.
        files: where references may lead.
        findings: takes errors, the lint of the timestep and notes on what was resolved.
        seed: of the sensors' noise.
    """
    before = len(findings.errors)
    if scene.spec.physics.tick_rate < SLOWEST:
        span = scene.document.span("physics", "tick_rate")
        findings.add("G109", f"tick_rate: physics needs at least {SLOWEST} ticks a second", span)
        return None
    builder = _Builder(scene, files, findings)
    world = builder.world()
    robots = builder.robots()
    if world is None or len(findings.errors) > before:
        return None
    model = builder.compile(world, robots)
    if model is None:
        return None
    stage = Stage()
    add_world(stage, model, robots)
    bodies = {model.body(index).name for index in range(model.nbody)}
    for robot in robots.values():
        add_robot(stage, robot, bodies, findings)
    if len(findings.errors) > before:
        return None
    physics, settle = scene.spec.physics, scene.spec.settle
    rate = Fraction(repr(physics.tick_rate))
    try:
        simulation = Simulation(model, stage, rate, physics.substeps, seed=seed, settle=settle)
    except PhysicsError as error:
        message, *remedy = str(error).split("\n")
        findings.add("S106", message, scene.document.key_span("settle" if settle else "world"), *remedy)
        return None
    _note_limits(simulation.unlimited, robots, findings)
    if settle and simulation.settled_after is None:
        findings.add("N103", "not at rest after 5 s; t = 0 begins as it is", scene.document.key_span("settle"))
    return LoadedWorld(simulation, stage, robots, world)


class _Builder:
    def __init__(self, scene: Loaded[SceneSpec], files: Files, findings: Findings) -> None:
        self.scene = scene
        self.files = files
        self.findings = findings
        self.library = Library(files, findings)
        self._lines: list[Span] = []

    def _find(self, reference: str, *location: str) -> Path | None:
        try:
            return self.files.find(reference, self.scene.folder)
        except NotFoundError as error:
            self.findings.add("S101", error.message, self.scene.document.span(*location), *error.help)
            return None

    def world(self) -> mujoco.MjSpec | None:
        """The world's MJCF, parsed, with the options that every scene has."""
        path = self._find(self.scene.spec.world, "world")
        root = self.library.world(path) if path is not None else None
        if root is None:
            return None
        text, self._lines = write(root)
        try:
            spec = mujoco.MjSpec.from_string(text, include=self.library.models, assets=self.library.assets)
        except (ValueError, mujoco.FatalError) as error:
            message, _, line = mujoco_says(error)
            self.findings.add("S102", f"MuJoCo: {message}", place_of(self._lines, line))
            return None
        self._set_options(spec, root)
        for index, body in enumerate(spec.bodies):
            if not body.name:
                body.name = f"body_{index}"
        return spec

    def _set_options(self, spec: mujoco.MjSpec, root: Element) -> None:
        stated = {name: option for option in root.all("option") for name in option.attributes}
        physics = self.scene.spec.physics
        timestep = float(1 / (Fraction(repr(physics.tick_rate)) * physics.substeps))
        if "timestep" in stated and abs(spec.option.timestep - timestep) > 1e-9 * timestep:
            span = stated["timestep"].place("timestep")
            ours = f"the scene's {timestep:g} s: {physics.tick_rate:g} ticks a second of {physics.substeps} substeps"
            self.findings.add("W204", f"timestep {spec.option.timestep:g} s is overruled by {ours}", span)
        spec.option.timestep = timestep
        if "integrator" in stated and spec.option.integrator != mujoco.mjtIntegrator.mjINT_DISCRETE:
            span = stated["integrator"].place("integrator")
            why = "no other solves the damping of drives together with contacts"
            self.findings.add("N103", "the integrator is 'discrete' in every scene", span, why)
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        if "cone" not in stated:
            spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        if "impratio" not in stated:
            # A wheel that pushes slips by up to 0.6 % at MuJoCo's 1, by 0.08 % at 10.
            spec.option.impratio = 10.0

    def robots(self) -> dict[str, Robot]:
        """The scene's robots that are sound, in order."""
        found: dict[str, Robot] = {}
        for name, use in self.scene.spec.robots.items():
            if name == "World":
                span = self.scene.document.key_span("robots", name)
                self.findings.add("S105", "a robot cannot be named 'World': the world's prims are there", span)
                continue
            path = self._find(use.use, "robots", name, "use")
            file = read_robot(path, self.files, self.findings) if path is not None else None
            robot = load_robot(name, use, file, self.files, self.findings) if file is not None else None
            if robot is not None:
                found[name] = robot
        return found

    def compile(self, world: mujoco.MjSpec, robots: dict[str, Robot]) -> mujoco.MjModel | None:
        """Attach the robots and compile."""
        floor = _floor_friction(world)
        before = len(self.findings.errors)
        for name, robot in robots.items():
            spec = robot_spec(robot, self.library, floor, self.findings)
            if spec is None:
                continue
            x, y, z, w = from_orientation(robot.use.orientation)
            frame = world.worldbody.add_frame(pos=robot.use.position, quat=(w, x, y, z))
            try:
                world.attach(spec, frame=frame, prefix=f"{name}/")
            except (ValueError, mujoco.FatalError) as error:
                self._refused(error, robots)
        if len(self.findings.errors) > before:
            return None
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                model = world.compile()
        except (ValueError, mujoco.FatalError) as error:
            self._refused(error, robots)
            return None
        for warning in caught:
            self._warned(str(warning.message), model, robots)
        return model

    def _warned(self, text: str, model: mujoco.MjModel, robots: dict[str, Robot]) -> None:
        """Tell what MuJoCo thinks of a model that it compiled, at the joint if it numbers one."""
        sentence, number = text.partition(" Time =")[0], _DEGREE_OF_FREEDOM.search(text)
        span, where = self.scene.document.key_span("world"), ""
        if number is not None and int(number[1]) < model.nv:
            index = int(model.dof_jntid[int(number[1])])
            name = model.joint(index).name or model.body(int(model.jnt_bodyid[index])).name
            where = f"degree of freedom {number[1]} belongs to {name!r}"
            span = element.span if (element := _element(name, robots)) is not None else span
        self.findings.add("W205", f"MuJoCo: {sentence}", span, where)

    def _refused(self, error: Exception, robots: dict[str, Robot]) -> None:
        """Tell MuJoCo's sentence where its element stands: in a robot's description if the name says so, else in the world."""
        message, name, line = mujoco_says(error)
        element = _element(name, robots)
        if element is not None:
            self.findings.add("S106", f"MuJoCo: {message}: {name.partition('/')[2]!r}", element.span)
        else:
            self.findings.add("S106", f"MuJoCo: {message}", place_of(self._lines, line))


def _element(name: str, robots: dict[str, Robot]) -> Element | None:
    """What a robot's description calls so, or the whole description; None for what belongs to no robot."""
    owner, _, rest = name.partition("/")
    if owner not in robots:
        return None
    root = robots[owner].urdf.element
    return next((element for element in root.walk() if element.get("name") == rest.partition(".")[0]), root)


def _note_limits(joints: Sequence[str], robots: dict[str, Robot], findings: Findings) -> None:
    for joint in joints:
        robot, _, name = joint.partition("/")
        text = (
            f"joint {name!r}: its effort limit is not enforced, as its drive is too stiff to saturate in a stable way"
        )
        findings.add("N103", text, robots[robot].file.key_span("joints", name), "a max_acceleration bounds the effort")


def _floor_friction(world: mujoco.MjSpec) -> float:
    """Sliding friction of the world's first plane."""
    planes = (geom for geom in world.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE)
    return next((float(geom.friction[0]) for geom in planes), NO_FLOOR_FRICTION)
