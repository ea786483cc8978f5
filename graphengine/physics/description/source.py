"""Loads the description of a robot file: finds it, expands xacro, resolves packages."""

from __future__ import annotations

from pathlib import Path

from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.physics.description import xacro
from graphengine.physics.description.robot_file import RobotFile
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.description.urdf_reader import read_urdf
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import read


def read_description(file: RobotFile, files: Files, findings: Findings) -> Urdf | None:
    """The description that a robot file names; what is wrong with it goes to `findings`."""
    if not file.spec.urdf:
        span = file.chain[0].document.span().part(0, 1)
        findings.add("G107", "missing key 'urdf'", span, "the file of the description")
        return None
    path = files.look_up(file.spec.urdf, file.folder("urdf"), findings, file.span("urdf"))
    packages = _packages(path, file, files, findings) if path is not None else None
    if path is None or packages is None:
        return None
    root = read(path, findings, "S103")
    if root is None:
        return None
    if path.suffix == xacro.SUFFIX or xacro.is_xacro(root):
        arguments = {name: _as_text(value) for name, value in file.spec.xacro_arguments.items()}
        places = {name: file.key_span("xacro_arguments", name) for name in arguments}
        root = xacro.expand(path, arguments, packages, findings, places)
    elif file.spec.xacro_arguments:
        span = file.key_span("xacro_arguments")
        findings.add("G109", f"xacro_arguments: no xacro syntax in {file.spec.urdf!r}", span)
        return None
    return read_urdf(root, packages, findings) if root is not None else None


def _packages(path: Path, file: RobotFile, files: Files, findings: Findings) -> Packages | None:
    before = len(findings.errors)
    paths = [file.folder("package_paths") / reference for reference in file.spec.package_paths]
    for index, (reference, folder) in enumerate(zip(file.spec.package_paths, paths, strict=True)):
        span = file.span("package_paths", index)
        if not files.may_read(folder):
            remedy = f"allow it with --allow {folder.resolve()}"
            findings.add("S103", f"{reference!r} lies outside the folder of the file you gave", span, remedy)
        elif not folder.is_dir():
            findings.add("S101", f"no folder {reference!r}", span, f"looked in {folder.parent}")
    return Packages(path.parent, paths, files) if len(findings.errors) == before else None


def _as_text(value: str | float | bool) -> str:
    """A value of a robot file as xacro has it."""
    return str(value).lower() if isinstance(value, bool) else str(value)
