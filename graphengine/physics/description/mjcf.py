"""MuJoCo models used directly as robots: one body with its children, of which the stage knows only the root.

Their joints and actuators are not accessible to graphs; graphs that command or read joints need a URDF and a robot file.
"""

from __future__ import annotations

from pathlib import Path

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing
from graphengine.physics.description.description_reader import is_text, with_robot_file
from graphengine.physics.description.robot_file import RobotFile
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.description.urdf_reader import read_urdf
from graphengine.physics.engine import REFUSALS, mujoco
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.references import Library
from graphengine.physics.files.xml import Element, mujoco_says, place_of, write

SUFFIX = ".xml"


def is_mjcf(use: str) -> bool:
    """Return whether a scene's `use` is a MuJoCo model: a file or a text."""
    if is_text(use):
        robot, model = (use.find(f"<{tag}") for tag in ("robot", "mujoco"))
        return model >= 0 and not 0 <= robot < model
    return Path(use).suffix == SUFFIX


def read_mjcf(use: str, path: Path, library: Library) -> tuple[RobotFile, Urdf, mujoco.MjSpec] | None:
    """Return a model, with a robot file and a description with one link for it; errors are added to the library's findings.

    Args:
        use: text of the model, or its file name.
        path: path of its file; for a text, its name in messages and the folder of its references.
        library: reads the files to which it refers.
    """
    findings = library.findings
    root = library.world(path, use if is_text(use) else None)
    if root is None:
        return None
    spec, _ = parse(root, library)
    body = _only_body(spec, root.span, findings) if spec is not None else None
    if spec is None or body is None:
        return None
    link = Element("robot", {"name": body.name}, root.span, [Element("link", {"name": body.name}, root.span)])
    urdf = read_urdf(link, Packages(path.parent, (), library.files), findings)
    bare = with_robot_file(urdf, path, findings)
    return (*bare, spec) if bare is not None else None


def parse(root: Element, library: Library, code: str = "S102") -> tuple[mujoco.MjSpec | None, list[Span]]:
    """Return MuJoCo's model of MJCF or URDF with names for all bodies, and the origin of each line of the parsed text.

    Args:
        root: root element from the library or from `for_mujoco`.
        library: library with the referenced files; its findings receive an error if MuJoCo refuses the model.
        code: code of that error.
    """
    text, lines = write(root)
    try:
        spec = mujoco.MjSpec.from_string(text, include=library.models, assets=library.assets)
    except REFUSALS as error:
        message, _, line = mujoco_says(error)
        library.findings.add(code, f"MuJoCo: {message}", place_of(lines, line))
        return None, lines
    for index, body in enumerate(spec.bodies):
        if not body.name:
            body.name = f"body_{index}"
    return spec, lines


def _only_body(spec: mujoco.MjSpec, span: Span, findings: Findings) -> mujoco.MjsBody | None:
    """Return the only body of a model; its lights, cameras and keyframes are deleted."""
    world = spec.worldbody
    for alone in (*list(world.lights), *list(world.cameras), *list(spec.keys)):
        spec.delete(alone)
    bodies = list(world.bodies)
    if len(bodies) != 1 or list(world.geoms):
        text = "an MJCF file of a robot or object must contain one body, and no geoms outside of it"
        names = [body.name for body in bodies] + [geom.name or "a geom of no body" for geom in world.geoms]
        findings.add("S102", text, span, listing(names, "it contains"))
        return None
    return bodies[0]
