"""Reads robot descriptions (URDF, xacro, SDF): those that robot files name, and others, for which a robot file is made."""

from __future__ import annotations

from pathlib import Path

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.spec_reader import Loaded, validate
from graphengine.physics.description import xacro
from graphengine.physics.description.robot_file import RobotFile
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.description.urdf_reader import read_urdf
from graphengine.physics.files.packages import Packages
from graphengine.physics.files.xml import Element, parse, read
from graphengine.physics.importing import joint_drives
from graphengine.physics.importing.draft import Draft
from graphengine.physics.importing.writer import render
from graphengine.physics.sdf.sdf_files import SUFFIXES as SDF_SUFFIXES
from graphengine.physics.sdf.sdf_files import is_sdf
from graphengine.physics.sdf.sdf_reader import read_sdf

SUFFIXES = (".urdf", xacro.SUFFIX, *SDF_SUFFIXES)


def read_description(file: RobotFile, files: Files, findings: Findings) -> Urdf | None:
    """Read the description that a robot file names. Errors are added to `findings`."""
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
    if xacro.is_xacro(path, root):
        arguments = {name: _as_text(value) for name, value in file.spec.xacro_arguments.items()}
        places = {name: file.key_span("xacro_arguments", name) for name in arguments}
        root = xacro.expand(path, arguments, packages, findings, places)
    elif file.spec.xacro_arguments:
        span = file.key_span("xacro_arguments")
        findings.add("G109", f"xacro_arguments: {file.spec.urdf!r} does not use xacro", span)
        return None
    return _converted(path, root, packages, findings)


def _converted(path: Path, root: Element | None, packages: Packages, findings: Findings) -> Urdf | None:
    """Return the links and joints of URDF or SDF; None after an error."""
    if root is not None and is_sdf(root):
        root = read_sdf(path, root, packages, findings)
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
    """Return a value of a robot file as text for xacro."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def is_text(use: str) -> bool:
    """Return whether a scene has the text of a description instead of a file name."""
    return use.lstrip()[:1] == "<"


def read_bare(use: str, path: Path, files: Files, findings: Findings) -> tuple[RobotFile, Urdf] | None:
    """Read a description, and make a robot file for it. Errors are added to `findings`.

    Args:
        use: text of the description, or its file name.
        path: path of its file; for a text, its name in messages and the folder of its references.
        files: decides which files may be read.
        findings: receives errors.
    """
    packages = Packages(path.parent, (), files)
    root = parse(use.encode(), path.name, findings, "S103") if is_text(use) else read(path, findings, "S103")
    if root is not None and not is_text(use) and xacro.is_xacro(path, root):
        root = xacro.expand(path, {}, packages, findings)
    return with_robot_file(_converted(path, root, packages, findings), path, findings)


def with_robot_file(urdf: Urdf | None, path: Path, findings: Findings) -> tuple[RobotFile, Urdf] | None:
    """Return a description with a plain robot file: wheels have velocity drives, all else is as the description says."""
    if urdf is None:
        return None
    draft = Draft(urdf, "bare", path.name, path.name)
    draft.fixed_base = any(each.first("static") is not None for each in urdf.element.all("gazebo"))
    joint_drives.plain(draft)
    file = robot_file(render(draft), path, findings)
    return (file, urdf) if file is not None else None


def robot_file(text: str, path: Path, findings: Findings) -> RobotFile | None:
    """Parse the text of a robot file."""
    parsed = document.parse(text, str(path), findings)
    spec = validate(RobotSpec, parsed, parsed.data, findings) if parsed is not None else None
    return RobotFile(spec, (Loaded(spec, parsed),)) if parsed is not None and spec is not None else None
