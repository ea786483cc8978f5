"""Builds the MjSpec of a scene's world from MJCF, SDF or USD. Robots are attached to this MjSpec."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from graphengine.descriptions.earth import place_world
from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, number, read
from graphengine.descriptions.mjcf.mjcf import is_safe, parse
from graphengine.descriptions.mjcf.mjcf_trial import is_plain
from graphengine.descriptions.routes import PREFIX
from graphengine.descriptions.sdf.sdf_files import SUFFIXES, is_sdf
from graphengine.descriptions.sdf.sdf_world import read_world
from graphengine.descriptions.usd.stage_files import StageChoice
from graphengine.descriptions.usd.usd_world import read_usd_world
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.files import USD
from graphengine.format.scene_spec import PhysicsSpec, SceneSpec
from graphengine.format.spec_reader import Loaded
from graphengine.format.wording import listing
from graphengine.physics.model.mover_bodies import add_movers

_DRIVEN_BY = {
    "spring": mujoco.mjtDisableBit.mjDSBL_SPRING,
    "damper": mujoco.mjtDisableBit.mjDSBL_DAMPER,
    "actuation": mujoco.mjtDisableBit.mjDSBL_ACTUATION,
}
"""A dict from the MJCF flag of each MuJoCo feature that drives need to its disable bit."""


def world_spec(
    scene: Loaded[SceneSpec], library: Library, findings: Findings
) -> tuple[mujoco.MjSpec | None, list[Span]]:
    """Return the world of a scene as an MjSpec with the options that all scenes have; None after an error.

    The second value is the source location of each line of the parsed text. SDF and USD worlds are converted to MJCF.

    Args:
        scene: scene with the path of the world, the tick rate and the number of substeps.
        library: reads the world and the files to which it refers.
        findings: receives errors, and notes on overridden options.
    """
    path = library.files.look_up(scene.spec.world, scene.folder, findings, scene.document.span("world"), stages=True)
    root = _read(path, scene, library, findings) if path is not None else None
    if root is None or path is None:
        return None, []
    if not (library.is_shipped(path) or is_plain(root, library.memory) or is_safe(root, library, "world")):
        return None, []
    spec, lines = parse(root, library)
    if spec is not None:
        _set_options(spec, root, scene.spec.physics, findings)
        if scene.spec.spherical_coordinates is not None:
            place_world(spec, scene.spec.spherical_coordinates)
        if path.suffix not in SUFFIXES:
            for text in [text for text in spec.texts if text.name.startswith(PREFIX)]:
                spec.delete(text)  # only scenes and SDF worlds have movers
        add_movers(spec, scene, library, findings)
    return spec, lines


def _read(path: Path, scene: Loaded[SceneSpec], library: Library, findings: Findings) -> Element | None:
    """Return the root element of a world as MJCF, in which keys of the library replace file names; None after an error."""
    if path.suffix in USD:
        spec, folder = scene.spec, scene.folder
        robots = [use.at or f"/{name}" for name, use in spec.robots.items()]
        replaced = {url: str(folder / name) for url, name in spec.usd_replace.items()}
        choice = StageChoice("", spec.usd_variants, replaced, [folder / name for name in spec.usd_assets])
        made = read_usd_world(path, library, robots, choice)
        return made if made is not None and library.weigh(made) else None
    if path.suffix not in SUFFIXES:
        return library.world(path)
    root = read(path, findings, "S102")
    if root is not None and not is_sdf(root):
        findings.add("S102", f"{path.suffix} files begin with <sdf>, not <{root.tag[:40]}>", root.span)
        return None
    made = read_world(path, root, library, findings) if root is not None else None
    return made if made is not None and library.weigh(made) else None


def _set_options(spec: mujoco.MjSpec, root: Element, physics: PhysicsSpec, findings: Findings) -> None:
    stated = {name: option for option in root.all("option") for name in option.attributes}
    timestep = float(1 / (Fraction(repr(physics.tick_rate)) * physics.substeps))
    if "timestep" in stated and abs(spec.option.timestep - timestep) > 1e-9 * timestep:
        span = stated["timestep"].place("timestep")
        ours = f"the scene's {timestep:g} s: {physics.tick_rate:g} ticks a second of {physics.substeps} substeps"
        findings.add("W204", f"timestep {spec.option.timestep:g} s is overridden by {ours}", span)
    spec.option.timestep = timestep
    if "integrator" in stated and spec.option.integrator != mujoco.mjtIntegrator.mjINT_DISCRETE:
        span = stated["integrator"].place("integrator")
        why = "no other integrator solves the damping of drives together with contacts"
        findings.add("N103", "the integrator is replaced by 'discrete', which every scene uses", span, why)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    if "cone" not in stated:
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    if "impratio" not in stated:
        # A wheel that pushes slips by up to 0.6 % at MuJoCo's 1, by 0.08 % at 10.
        spec.option.impratio = 10.0
    _set_flags(spec, root, findings)


def tell_overridden(model: Element, world: mujoco.MjSpec, findings: Findings) -> None:
    """Add notes on options of a robot's MuJoCo model that the options of the world override.

    A timestep that equals that of the world is not reported.
    """
    stated = {name: option for option in model.all("option") for name in option.attributes}
    if (option := stated.pop("timestep", None)) is not None:
        given = number(option.get("timestep"))
        if given is not None and abs(given - world.option.timestep) > 1e-9 * world.option.timestep:
            text = f"timestep {given:g} s is overridden by the scene's {world.option.timestep:g} s"
            findings.add("W204", text, option.place("timestep"))
    flags = [flag for option in model.all("option") for flag in option.all("flag")]
    ignored = {name: option.place(name) for name, option in stated.items()}
    ignored |= {name: flag.place(name) for flag in flags for name in flag.attributes}
    if ignored:
        text = "options of the model have no effect: those of the scene's world apply to the whole scene"
        findings.add("N103", text, next(iter(ignored.values())), listing(ignored, "options"))


def _set_flags(spec: mujoco.MjSpec, root: Element, findings: Findings) -> None:
    flags = [flag for option in root.all("option") for flag in option.all("flag")]
    for flag, name in ((flag, name) for flag in flags for name in _DRIVEN_BY if flag.get(name) == "disable"):
        findings.add("N103", f"{name} is enabled in every scene, because drives need it", flag.place(name))
    for bit in _DRIVEN_BY.values():
        spec.option.disableflags &= ~int(bit)
    # The motion of a robot must not depend on other robots, to the last bit. Therefore contacts are solved island by island,
    # without warm starts (one choice of warm start serves all islands) and always with sparse matrices (`auto` switches at 60
    # degrees of freedom); see also `drives`. With 50 robots this is a third faster, too; with one robot it costs 4 %.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_WARMSTART
    spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
