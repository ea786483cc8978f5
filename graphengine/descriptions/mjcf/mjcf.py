"""Reads a MuJoCo model (MJCF) as the description of a robot.

Physics attaches the model unchanged. In addition, the links and joints of the compiled model are converted to plain data, as
for all formats; code outside physics does not depend on the format of the description.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from graphengine.descriptions.actuators.mjcf_actuators import read_actuators
from graphengine.descriptions.actuators.mjcf_model import MjcfModel, read_keyframes
from graphengine.descriptions.engine import REFUSALS, compiled, mujoco
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, mujoco_says, place_of, write
from graphengine.descriptions.link_tree import MAX_LINKS, check_limits
from graphengine.descriptions.mjcf.mjcf_links import MjcfLinks
from graphengine.descriptions.mjcf.mjcf_preparation import name_bodies, prepare
from graphengine.descriptions.mjcf.mjcf_trial import MAX_MEMORY_BYTES, reason_against
from graphengine.descriptions.robot_description import WORLD, RobotDescription
from graphengine.descriptions.urdf.urdf_reader import check_numbers
from graphengine.descriptions.urdf.urdf_writer import as_urdf
from graphengine.devices.rotation import Vector3, vector
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing
from graphengine.sandbox.confinement import MAX_CPU_SECONDS

_LIMITS = f"legal: up to {MAX_CPU_SECONDS} s of CPU time and {MAX_MEMORY_BYTES >> 30} GB of memory"
_ENDLESS = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)


def read_mjcf(path: Path, library: Library, text: str | None = None) -> RobotDescription | None:
    """Return the links and joints of a robot's MuJoCo model, with the model itself in `mjcf`; None after an error.

    Args:
        path: path of the model's file. If `text` is given, its name appears in messages, and relative references start from
            its folder.
        library: reads the files to which the model refers; its findings receive the errors.
        text: text of the model, if it is not in a file.
    """
    findings = library.findings
    root = library.world(path, text)
    if root is None or not is_safe(root, library):
        return None
    spec, lines = parse(root, library)
    if spec is None or not _is_robot(spec, root.span, findings):
        return None
    prepare(spec)
    try:
        model = compiled(spec)[0]
    except REFUSALS as error:
        message, _, line = mujoco_says(error)
        findings.add("S102", f"MuJoCo: {message}", place_of(lines, line))
        return None
    keyframes = read_keyframes(spec, model)
    for key in list(spec.keys):
        spec.delete(key)
    for actuator, ends in zip(spec.actuators, model.actuator_lengthrange, strict=True):
        actuator.lengthrange = ends  # otherwise each compilation would simulate muscles again
    links = MjcfLinks(model, dict(_meshes(spec, library)), _places(root), root.span)
    if len(links.links) > MAX_LINKS:
        findings.add("S103", f"more than {MAX_LINKS} links", root.span)
        return None
    packages = Packages(path.parent, (), library.files)
    document = as_urdf(spec.modelname, links.links.values(), links.joints.values(), root.span)
    before = len(findings.errors)
    for element in document.children:
        check_numbers(element, findings)
    check_limits(links.joints.values(), findings)
    if len(findings.errors) > before:
        return None
    mjcf = MjcfModel(spec, root, links.free, read_actuators(model), keyframes)
    return RobotDescription(document, packages, links.links, links.joints, links.root, mjcf)


def is_safe(root: Element, library: Library, what: str = "model") -> bool:
    """Return whether a confined process can compile a model within its limits; otherwise add an error.

    Args:
        root: root element of MJCF from the library.
        library: library with the referenced files; its findings receive the error.
        what: noun for the model in the error.
    """
    against = reason_against(write(root)[0], library.models, library.assets)
    if against:
        advice = "use fewer bodies and copies, smaller textures and coarser meshes"
        library.findings.add("S102", f"MuJoCo: compiling the {what} {against}", root.span, _LIMITS, advice)
    return not against


def parse(root: Element, library: Library) -> tuple[mujoco.MjSpec | None, list[Span]]:
    """Parse MJCF with MuJoCo; return its model specification, or None if MuJoCo refuses the text.

    All bodies of the specification have names. The second value is the source location of each line of the parsed text.

    Args:
        root: root element from the library.
        library: library with the referenced files; its findings receive an error if MuJoCo refuses the text.
    """
    text, lines = write(root)
    try:
        spec = mujoco.MjSpec.from_string(text, include=library.models, assets=library.assets)
    except REFUSALS as error:
        message, _, line = mujoco_says(error)
        library.findings.add("S102", f"MuJoCo: {message}", place_of(lines, line))
        return None, lines
    name_bodies(spec)
    return spec, lines


def _is_robot(spec: mujoco.MjSpec, span: Span, findings: Findings) -> bool:
    """Return whether a model has a body and no floor, and thus can be a robot; otherwise add an error.

    Lights and cameras attached to the world are deleted from the model, because the world of the scene has its own.
    """
    world = spec.worldbody
    for alone in (*list(world.lights), *list(world.cameras)):
        spec.delete(alone)
    if not list(world.bodies):
        names = [geom.name or "a geom outside of any body" for geom in world.geoms]
        findings.add("S102", "the model of a robot or object must contain a body", span, listing(names, "it contains"))
        return False
    floors = [geom.name or "one without a name" for geom in world.geoms if geom.type in _ENDLESS]
    if floors:
        advice = "name a file that contains only the robot; a model with a floor can be the `world:` of a scene"
        text = "the model of a robot or object contains a floor (plane or height field); floors belong to the scene's world"
        findings.add("S102", text, span, listing(floors, "it contains"), advice)
        return False
    return True


def _meshes(spec: mujoco.MjSpec, library: Library) -> Iterator[tuple[str, tuple[str, Vector3]]]:
    """Yield (name, (URI of the file, scale)) of each mesh that was read from a file."""
    for mesh in spec.meshes:
        source = library.source(mesh.file)
        if source is not None:
            yield mesh.name, (source.as_uri(), vector(mesh.scale))


def _places(root: Element) -> dict[str, Span]:
    """Return a dict from names to the source location of the first body, joint, site or camera with this name."""
    found: dict[str, Span] = {WORLD: root.span}
    for element in root.walk():
        if element.tag in ("body", "joint", "freejoint", "site", "camera") and "name" in element.attributes:
            found.setdefault(element.get("name"), element.span)
    return found
