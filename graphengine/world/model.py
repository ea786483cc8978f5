"""From a scene file to one compiled model, its stage and its simulation."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from graphengine.diagnostics import Findings, PhysicsError, Span
from graphengine.files import Files, NotFoundError
from graphengine.spec import SceneSpec
from graphengine.spec_reader import Loaded
from graphengine.stage import PHYSICS_SCENE, Stage
from graphengine.world.engine import REFUSALS, mujoco
from graphengine.world.fleet import placements
from graphengine.world.force_limits import tell_limits
from graphengine.world.prims import add_robot, add_world
from graphengine.world.references import Library
from graphengine.world.robot import Robot
from graphengine.world.scenery import Scenery, body_names
from graphengine.world.sensors.rays import RaysChoice
from graphengine.world.simulation import Simulation
from graphengine.world.xmlfile import Element, mujoco_says, place_of, write

SLOWEST = 0.1
"""Ticks a second below which a step is too long for any physics."""

_DRIVEN_BY = {
    "spring": mujoco.mjtDisableBit.mjDSBL_SPRING,
    "damper": mujoco.mjtDisableBit.mjDSBL_DAMPER,
    "actuation": mujoco.mjtDisableBit.mjDSBL_ACTUATION,
}
"""MuJoCo's parts that drives are made of, by the flags of a world that could disable them."""


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
    builder = _Builder(scene, files, findings)
    scenery = builder.scenery()
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

    def scenery(self) -> Scenery:
        """The world, and no robot yet."""
        return Scenery(self.scene, self.world(), self._lines, self.library)

    def world(self) -> mujoco.MjSpec | None:
        """The world's MJCF, parsed, with the options that every scene has."""
        path = self._find(self.scene.spec.world, "world")
        root = self.library.world(path) if path is not None else None
        if root is None:
            return None
        text, self._lines = write(root)
        try:
            spec = mujoco.MjSpec.from_string(text, include=self.library.models, assets=self.library.assets)
        except REFUSALS as error:
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
        self._set_flags(spec, root)

    def _set_flags(self, spec: mujoco.MjSpec, root: Element) -> None:
        flags = [flag for option in root.all("option") for flag in option.all("flag")]
        for flag, name in ((flag, name) for flag in flags for name in _DRIVEN_BY if flag.get(name) == "disable"):
            self.findings.add("N103", f"{name} is enabled in every scene: drives are made of it", flag.place(name))
        for bit in _DRIVEN_BY.values():
            spec.option.disableflags &= ~int(bit)
        # What a robot does must not depend on who else is there, to the last bit. So what touches is solved island by island,
        # from a start of its own (one choice of warm start serves all islands) and in one form (`auto` changes it at 60 degrees
        # of freedom); `drives` has the rest. With 50 robots this is a third faster, too; with one it costs 4 %.
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART
        spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
