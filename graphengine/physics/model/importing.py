"""Imports a description as a robot for `graphrun import-urdf`, and tests it before any file is written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.files import shipped
from graphengine.format.spec import RobotUse
from graphengine.physics.description.description_reader import robot_file
from graphengine.physics.description.robot_file_writer import compose
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.description.urdf_reader import read_urdf
from graphengine.physics.engine import REFUSALS, body_names, collides, compiled, mujoco
from graphengine.physics.files.packages import Packages, package_of
from graphengine.physics.files.references import Library
from graphengine.physics.files.xml import Element, mujoco_says, write
from graphengine.physics.model.fleet_expansion import place
from graphengine.physics.model.geoms import extents
from graphengine.physics.model.robot import RobotInstance, load_robot
from graphengine.physics.model.robot_model import robot_spec
from graphengine.physics.model.robot_prims import add_robot

_FLOOR_FRICTION = 1.0
_MESHES = ("mesh", "texture")


@dataclass(frozen=True, slots=True)
class Origin:
    """The source of a description, and the target for its robot file.

    Attributes:
        element: root element, with xacro expanded.
        packages: packages of its meshes.
        path: path of the description; None if it must be written, because it comes from xacro or the network.
        told: name of the source in messages.
        target: path of the robot file.
        fixed_base: whether the root link is fixed to the world.
    """

    element: Element
    packages: Packages
    path: Path | None
    told: str
    target: Path
    fixed_base: bool


@dataclass(frozen=True, slots=True)
class Imported:
    """An imported robot, which was compiled once, and the texts of its files.

    Attributes:
        robot: the robot as in a scene.
        free: whether its root link moves.
        lowest: height (m) of the lowest point of its colliders above its root link, all joints at zero; None without colliders.
        library: library with its meshes.
        files: texts by path, the robot file last.
        outside: folders outside the robot file's project, for which scenes need `--allow`.
        use: name of the robot file in scenes of its project.
    """

    robot: RobotInstance
    free: bool
    lowest: float | None
    library: Library
    files: dict[Path, str]
    outside: list[Path]
    use: str


def import_robot(origin: Origin, findings: Findings) -> Imported | None:
    """Test a description and return the robot; errors are added to `findings`."""
    urdf = read_urdf(origin.element, origin.packages, findings)
    if urdf is None:
        return None
    name, files = origin.target.stem, origin.packages.files
    packages = list(_used_packages(urdf))
    path = origin.path or origin.target.with_suffix(".urdf")
    told = [_near(folder, origin.target) for folder in packages]
    text = compose(urdf, name, origin.told, _near(path, origin.target), told, fixed_base=origin.fixed_base)
    file = robot_file(text, origin.target, findings)
    (placement,) = place(name, RobotUse(use=str(origin.target)))
    robot = load_robot(placement, file, files, findings, urdf) if file is not None else None
    library = Library(files, findings)
    spec = robot_spec(robot, library, _FLOOR_FRICTION, findings) if robot is not None else None
    model = _compiled(spec, urdf, findings) if spec is not None else None
    if robot is None or model is None:
        return None
    bodies = {f"{name}/{body}" for body in body_names(model)}
    before = len(findings.errors)
    add_robot(Stage(), robot, bodies, findings)
    if len(findings.errors) > before:
        return None
    written = {} if origin.path is not None else {path: _portable(urdf)}
    return Imported(
        robot=robot,
        free=robot.disabled.free_link is not None,
        lowest=_lowest(model),
        library=library,
        files={**written, origin.target: text},
        outside=_outside([*packages, path], origin),
        use=os.path.relpath(origin.target.parent.resolve() / origin.target.name, _project(origin.target)),
    )


def _compiled(spec: mujoco.MjSpec, urdf: Urdf, findings: Findings) -> mujoco.MjModel | None:
    try:
        model, told = compiled(spec)
    except REFUSALS as error:
        message, name, _ = mujoco_says(error)
        owners = (name, name.rsplit(".", 2)[0])  # a geom is named by its link and two numbers
        places = (element.span for element in urdf.element.walk() if element.get("name") in owners)
        findings.add("S106", f"MuJoCo: {message}: {name!r}", next(places, urdf.element.span))
        return None
    for text in told:
        findings.add("W205", f"MuJoCo: {text}", urdf.element.span)
    return model


def _lowest(model: mujoco.MjModel) -> float | None:
    """Height of the robot's lowest collider relative to its root link, m; None without colliders."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = extents(model, data, np.flatnonzero(collides(model)))
    return float(found[0][2]) if found is not None else None


def _used_packages(urdf: Urdf) -> Iterator[Path]:
    """Yield the folders of packages with meshes of the robot, except installed packages, which are found anyway."""
    meshes = (element.get("filename") for element in urdf.element.walk() if element.tag in _MESHES)
    names = dict.fromkeys(name for reference in meshes if (name := package_of(reference)) is not None)
    for name in names:
        folder = urdf.packages.find(name)
        if folder is not None and not any(folder.is_relative_to(i) for i in urdf.packages.files.installed):
            yield folder.resolve()


def _portable(urdf: Urdf) -> str:
    """Return the description as text that works in any folder: relative references become absolute."""
    for element in urdf.element.walk():
        reference = element.get("filename")
        if element.tag in _MESHES and reference and "://" not in reference:
            element.attributes["filename"] = (urdf.packages.folder / reference).resolve().as_uri()
    return '<?xml version="1.0"?>\n' + write(urdf.element)[0] + "\n"


def _near(path: Path, target: Path) -> str:
    """Return a path as it is written in a robot file: relative if it is within the project, else absolute."""
    resolved, folder = path.resolve(), target.parent.resolve()
    return os.path.relpath(resolved, folder) if resolved.is_relative_to(_project(target)) else str(resolved)


def _project(target: Path) -> Path:
    """Return the project's folder: that of the robot file, or the one around it if its name is `robots`."""
    folder = target.parent.resolve()
    return folder.parent if folder.name == "robots" else folder


def _outside(paths: list[Path], origin: Origin) -> list[Path]:
    """Return the folders of these paths that scenes of the project may read only with `--allow`."""
    known = [_project(origin.target), shipped() / "scenes", *origin.packages.files.installed]
    found: list[Path] = []
    for path in paths:
        if not any(path.resolve().is_relative_to(folder) for folder in (*known, *found)):
            found.append(path.resolve() if path.is_dir() else path.resolve().parent)
    return found
