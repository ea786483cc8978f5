"""Robot specs of descriptions without a robot file, as `graphrun import-urdf` would write them."""

from __future__ import annotations

from pathlib import Path

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.spec import RobotSpec
from graphengine.format.spec_reader import Loaded, validate
from graphengine.physics.description import xacro
from graphengine.physics.description.robot_file import RobotFile
from graphengine.physics.description.robot_file_writer import compose
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.description.urdf_reader import read_urdf
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import Element, parse, read

SUFFIXES = (".urdf", xacro.SUFFIX)


def is_text(use: str) -> bool:
    """Whether a scene gives the text of a description instead of a file name."""
    return use.lstrip()[:1] == "<"


def read_bare(use: str, path: Path, files: Files, findings: Findings) -> tuple[RobotFile, Urdf] | None:
    """Read a description, and the robot file for it. Errors are added to `findings`.

    Args:
        use: its text, or else its name.
        path: of its file; a text goes by this name, and its references begin in that folder.
        files: judges what may be read.
        findings: takes what is wrong.
    """
    packages = Packages(path.parent, (), files)
    root: Element | None
    if is_text(use):
        root = parse(use.encode(), path.name, findings, "S103")
    else:
        root = read(path, findings, "S103")
        if root is not None and (path.suffix == xacro.SUFFIX or xacro.is_xacro(root)):
            root = xacro.expand(path, {}, packages, findings, {})
    urdf = read_urdf(root, packages, findings) if root is not None else None
    return with_robot_file(urdf, path, findings)


def with_robot_file(urdf: Urdf | None, path: Path, findings: Findings) -> tuple[RobotFile, Urdf] | None:
    """The robot file that `graphrun import-urdf` would write for a description, and the description."""
    if urdf is None:
        return None
    file = robot_file(compose(urdf, "bare", path.name, path.name, (), fixed_base=False), path, findings)
    return (file, urdf) if file is not None else None


def robot_file(text: str, path: Path, findings: Findings) -> RobotFile | None:
    """Parse the text of a robot file."""
    parsed = document.parse(text, str(path), findings)
    spec = validate(RobotSpec, parsed, parsed.data, findings) if parsed is not None else None
    return RobotFile(spec, (Loaded(spec, parsed),)) if parsed is not None and spec is not None else None
