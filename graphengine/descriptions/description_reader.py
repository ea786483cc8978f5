"""Reads robot descriptions (URDF, xacro, SDF, MJCF, USD), with the robot file that names them or with a generated one."""

from __future__ import annotations

from pathlib import Path

from graphengine.descriptions.added_formats import is_added, read_root
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, parse
from graphengine.descriptions.mjcf.mjcf import read_mjcf
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.robot_files.default_drives import add_stated_drives, add_wheel_drives
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.robot_files.mjcf_parts import add_model_parts
from graphengine.descriptions.robot_files.robot_file import RobotFile
from graphengine.descriptions.robot_files.stage_parts import add_stage_parts
from graphengine.descriptions.sdf.sdf_files import SUFFIXES as SDF_SUFFIXES
from graphengine.descriptions.sdf.sdf_files import is_sdf
from graphengine.descriptions.sdf.sdf_reader import read_sdf
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.descriptions.usd.stage_files import SUFFIXES as USD_SUFFIXES
from graphengine.descriptions.usd.stage_files import StageChoice
from graphengine.descriptions.usd.usd_reader import read_usd
from graphengine.descriptions.xacro import xacro
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document, Value
from graphengine.format.files import Files
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.spec_reader import Loaded, validate
from graphengine.format.wording import allowing
from graphengine.format.yaml_text import read_back

MJCF_SUFFIX = ".xml"
SUFFIXES = (".urdf", xacro.SUFFIX, MJCF_SUFFIX, *SDF_SUFFIXES, *USD_SUFFIXES)


def read_description(file: RobotFile, library: Library) -> RobotDescription | None:
    """Read the description that a robot file names by `urdf`, `mjcf` or `usd`, and return its links and joints.

    Return None after an error; errors are added to the findings of the library.
    """
    files, findings = library.files, library.findings
    if file.spec.mjcf or file.spec.usd:
        return _read_model(file, library)
    if not file.spec.urdf:
        span = file.chain[0].document.span().part(0, 1)
        remedy = "name a robot description by `urdf`, a MuJoCo model by `mjcf`, or a USD stage by `usd`"
        findings.add("G107", "missing key 'urdf'", span, remedy)
        return None
    path = files.look_up(file.spec.urdf, file.folder("urdf"), findings, file.span("urdf"))
    packages = _packages(path, file, files, findings) if path is not None else None
    if path is None or packages is None:
        return None
    root = read_root(path, findings)
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


def _converted(path: Path, root: Element | None, packages: Packages, findings: Findings) -> RobotDescription | None:
    """Return the links and joints of a parsed URDF or SDF file; None after an error."""
    if root is None:
        return None
    return read_sdf(path, root, packages, findings) if is_sdf(root) else read_urdf(root, packages, findings)


def _read_model(file: RobotFile, library: Library) -> RobotDescription | None:
    """Return the MuJoCo model that a robot file names by `mjcf`, or the robot of a stage by `usd`; None after an error."""
    named, what = ("mjcf", "a MuJoCo model") if file.spec.mjcf else ("usd", "a USD stage")
    others = ("usd",) if file.spec.mjcf else ()
    for key in ("urdf", "xacro_arguments", "package_paths", *others):
        if getattr(file.spec, key):
            text = f"{key}: not allowed beside `{named}`, which names {what}"
            library.findings.add("G109", text, file.key_span(key))
            return None
    path = library.files.look_up(
        getattr(file.spec, named), file.folder(named), library.findings, file.span(named), stages=named == "usd"
    )
    if path is None or named == "mjcf":
        return read_mjcf(path, library) if path is not None else None
    spec = file.spec
    replaced = {url: str(file.folder("usd_replace", url) / name) for url, name in spec.usd_replace.items()}
    mirrors = [file.folder("usd_assets") / name for name in spec.usd_assets]
    return read_usd(
        path, library.files, library.findings, StageChoice(spec.usd_robot, spec.usd_variants, replaced, mirrors)
    )


def _packages(path: Path, file: RobotFile, files: Files, findings: Findings) -> Packages | None:
    before = len(findings.errors)
    paths = [file.folder("package_paths") / reference for reference in file.spec.package_paths]
    for index, (reference, folder) in enumerate(zip(file.spec.package_paths, paths, strict=True)):
        span = file.span("package_paths", index)
        if not files.may_read(folder):
            what = f"{reference!r} lies outside the folder of the file you gave"
            findings.add("S103", what, span, allowing(folder.resolve()))
        elif not folder.is_dir():
            findings.add("S101", f"no folder {reference!r}", span, f"searched in {folder.parent}")
    return Packages(path.parent, paths, files) if len(findings.errors) == before else None


def _as_text(value: str | float | bool) -> str:
    """Return the value of a xacro argument as text; booleans become `true` and `false`."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def is_description(path: Path) -> bool:
    """Return whether a file is a robot description, not a robot file, by its suffix."""
    return path.suffix in SUFFIXES or is_added(path)


def is_text(use: str) -> bool:
    """Return whether the `use` of a scene contains the text of a description (XML) instead of a file name."""
    return use.lstrip()[:1] == "<"


def is_mjcf(use: str) -> bool:
    """Return whether the `use` of a scene names an MJCF file, or contains the text of a MuJoCo model."""
    if is_text(use):
        robot, model = (use.find(f"<{tag}") for tag in ("robot", "mujoco"))
        return model >= 0 and not 0 <= robot < model
    return Path(use).suffix == MJCF_SUFFIX


def read_bare(use: str, path: Path, library: Library) -> tuple[RobotFile, RobotDescription] | None:
    """Read a description without a robot file; return it with a generated one, or None after an error.

    Args:
        use: text of the description, or name of its file.
        path: path of the file. For a text, its name appears in messages, and relative references start from its folder.
        library: reads referenced files; its findings receive the errors.
    """
    files, findings = library.files, library.findings
    if is_mjcf(use):
        description = read_mjcf(path, library, use if is_text(use) else None)
        return with_robot_file(description, path, findings)
    if not is_text(use) and path.suffix in USD_SUFFIXES:
        return with_robot_file(read_usd(path, files, findings), path, findings)
    packages = Packages(path.parent, (), files)
    root = parse(use.encode(), path.name, findings, "S103") if is_text(use) else read_root(path, findings)
    if root is not None and not is_text(use) and xacro.is_xacro(path, root):
        root = xacro.expand(path, {}, packages, findings)
    return with_robot_file(_converted(path, root, packages, findings), path, findings)


def with_robot_file(
    description: RobotDescription | None, path: Path, findings: Findings
) -> tuple[RobotFile, RobotDescription] | None:
    """Return a description together with a minimal generated robot file; None without a description, or after an error.

    For a URDF or SDF description, the robot file has velocity drives for the wheels. For a MuJoCo model, which defines its drives
    itself, it has the cameras and IMUs as sensors.
    """
    if description is None:
        return None
    draft = Draft(description, "bare", path.name, path.name)
    if description.mjcf is not None:
        add_model_parts(draft)
    elif description.usd is not None:
        add_stage_parts(draft)
        add_stated_drives(draft)
    else:
        draft.fixed_base = any(each.first("static") is not None for each in description.element.all("gazebo"))
        add_wheel_drives(draft)
    file = robot_file(draft, findings)
    return (file, description) if file is not None else None


def robot_file(draft: Draft, findings: Findings, document: Document | None = None) -> RobotFile | None:
    """Check the values of a draft as a robot file that extends no other; return None after an error.

    Args:
        draft: draft of the robot file.
        findings: receives errors.
        document: positions of the values; without it, findings refer to the root element of the description.
    """
    span = draft.description.element.span
    document = document or Document(span.source, Value(span, {}), 0)
    spec = validate(RobotSpec, document, read_back(draft.data()), findings)
    return RobotFile(spec, (Loaded(spec, document),)) if spec is not None else None
