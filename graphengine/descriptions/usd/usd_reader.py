"""Reads a robot of a USD stage as links and joints, with a `UsdModel` for what URDF lacks.

The stage is opened by a confined process; nothing of the stage is executed, and no server is asked.
"""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.link_tree import assembled
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.urdf.urdf_reader import check_numbers
from graphengine.descriptions.urdf.urdf_writer import as_urdf
from graphengine.descriptions.usd.articulations import Articulation, articulations
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_files import (
    AS_IT_IS,
    StageChoice,
    needed,
    tell_failure,
    tell_left_out,
    tell_process,
)
from graphengine.descriptions.usd.usd_links import UsdLinks
from graphengine.descriptions.usd.usd_masses import inertial_of
from graphengine.descriptions.usd.usd_settings import add_settings
from graphengine.descriptions.usd_model import PhysicsContents, UsdModel
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.wording import listing, printable
from graphengine.sandbox.borders import warn
from graphengine.sandbox.confinement import ProcessError, ask
from graphengine.sandbox.untrusted import note_used, read

MAX_SECONDS = 60.0
"""Maximum time to read the physics of a USD stage, s."""
MAX_ANSWER = 200_000_000
"""Maximum size of the result of the process that reads the physics of a stage, bytes."""
MAX_BODIES = 2000
"""Maximum number of bodies, and of joints, of a stage."""
_PROCESS = "graphengine.descriptions.usd.stage_physics_process"
_ASSETS = "--assets FOLDER names a folder with copies of such assets, --replace REFERENCE=FILE a file in place of one"


def read_physics(path: Path, files: Files, findings: Findings, choice: StageChoice) -> PhysicsContents | None:
    """Return the physics of a stage, or None after an error.

    Args:
        path: USD file.
        files: decides which files may be read.
        findings: receives errors, and warnings about parts that are left out.
        choice: variants, and places of assets.
    """
    spans = PrimSpans(path)
    if absent := needed():
        reason, _, remedy = absent.partition("\n")
        findings.add("S103", reason, spans.start, remedy.strip())
        return None
    warn(findings)
    try:
        contents = read(ask(_PROCESS, choice.request(path, files), MAX_SECONDS), PhysicsContents, MAX_ANSWER)
    except ProcessError as error:
        tell_process(error, "S103", spans, findings)
        return None
    note_used(contents.used, files)
    if contents.failure:
        tell_failure(contents.failure, "S103", spans, findings)
        return None
    if max(len(contents.bodies), len(contents.joints)) > MAX_BODIES:
        findings.add("S103", f"the stage has more than {MAX_BODIES} bodies or joints", spans.start)
        return None
    if contents.assumed and contents.bodies:
        text = f"the stage does not state its units or axes; assumed, as in Isaac Sim: {', '.join(contents.assumed)}"
        findings.add("N103", text, spans.start, "state them in the layer that is opened")
    if contents.textured:
        text = "textures of the stage are not drawn; plain colours are"
        findings.add("N103", text, spans.of(contents.textured), f"such as that of {contents.textured}")
    tell_left_out(contents.left_out, spans, findings, _ASSETS)
    return contents


def read_usd(path: Path, files: Files, findings: Findings, choice: StageChoice = AS_IT_IS) -> RobotDescription | None:
    """Return the links and joints of a robot of a stage, with `usd` set; None after an error.

    Args:
        path: USD file.
        files: decides which files may be read.
        findings: receives errors, warnings and notes.
        choice: what to read of the stage.
    """
    contents = read_physics(path, files, findings, choice)
    if contents is None:
        return None
    spans = PrimSpans(path)
    tree = chosen(contents, choice.robot, spans, findings)
    return description_of(contents, tree, path, files, findings) if tree is not None else None


def chosen(contents: PhysicsContents, name: str, spans: PrimSpans, findings: Findings) -> Articulation | None:
    """Return the robot with a name or path; None after an error.

    Without a name, it is the only one with moving joints, or else the only articulation, or else the only group of bodies.
    """
    found = articulations(contents)
    if name:
        named = [tree for tree in found if name in (tree.prim, tree.prim.rpartition("/")[2], tree.root)]
        named = [tree for tree in named if tree.moves] or named
        if len(named) != 1:
            known = listing((printable(tree.prim) for tree in found if tree.moves), "its robots")
            findings.add("S103", f"the stage has no robot {printable(name)!r}", spans.start, known)
        return named[0] if len(named) == 1 else None
    marked = [tree for tree in found if tree.marked]
    moving = [tree for tree in marked or found if tree.moves]
    robots = moving or marked or found
    if len(robots) != 1:
        known = listing((printable(robot.prim) for robot in robots), "its robots")
        what = "the stage has more than one robot" if robots else "the stage has no rigid body, so it has no robot"
        remedy = "choose one by --model PATH on import" if robots else "robots have prims with PhysicsRigidBodyAPI"
        findings.add("S103", what, spans.start, *filter(None, [known if robots else "", remedy]))
        return None
    return robots[0]


def meshes_of(contents: PhysicsContents) -> tuple[list[str], list[bytes]]:
    """Return the names of the meshes of a stage, equal for equal meshes of any stages, and their contents in MSH."""
    data = [base64.b64decode(mesh) for mesh in contents.meshes]
    return [f"mesh_{hashlib.sha256(mesh).hexdigest()[:16]}.msh" for mesh in data], data


def description_of(
    contents: PhysicsContents, tree: Articulation, path: Path, files: Files, findings: Findings
) -> RobotDescription | None:
    """Return the description of one articulation of a stage; None after an error, which is added to `findings`."""
    before, spans = len(findings.errors), PrimSpans(path)
    names, data = meshes_of(contents)
    made = UsdLinks(contents, tree, spans, names)
    for link, body in zip(made.links, tree.bodies, strict=True):
        link.inertial = inertial_of(made.bodies[body], made.frames[body], data)
    used = {shape.mesh for body in tree.bodies for shape in made.bodies[body].shapes}
    model = UsdModel(tree.prim, {name: prim for prim, name in made.names.items()})
    model.meshes = {names[index]: data[index] for index in used if index >= 0}
    model.files = [Path(used) for used in contents.used if files.may_read(Path(used))]
    model.pose, model.fixed = made.frame_in_world(tree.root), tree.holder is not None
    links, joints = made.links, made.joints
    add_settings(model, contents, made)
    span = spans.of(tree.prim)
    name = tree.prim.rpartition("/")[2] or path.stem
    document = as_urdf(name, links, joints, span)
    for element in document.children:
        check_numbers(element, findings)
    if len(findings.errors) > before:
        return None
    description = assembled(document, Packages(path.parent, (), files), links, joints, findings, before)
    if description is not None:
        description.usd = model
    return description
