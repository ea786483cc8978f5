"""Imports a description as a robot file for `graphrun import-robot`, and compiles the robot before any file is written."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.bringup.robots.arm_base import fix_arm
from graphengine.bringup.robots.arm_gains import set_gains
from graphengine.bringup.robots.bundle import bundle_graphs, bundle_meshes, bundle_model, bundle_stage
from graphengine.bringup.robots.drivetrain import add_drivetrain
from graphengine.bringup.robots.gazebo_links import add_link_settings
from graphengine.bringup.robots.gazebo_sensors import add_sensors
from graphengine.bringup.robots.joint_commands import add_mimics
from graphengine.bringup.robots.joint_dynamics import add_joint_dynamics, report_weak_wheels
from graphengine.bringup.robots.left_behind import report_unused
from graphengine.bringup.robots.resting import add_rest
from graphengine.bringup.robots.robot_source import WRAPPER
from graphengine.bringup.robots.trial import checked_spec
from graphengine.bringup.robots.wheels import add_wheel_material, find_wheels
from graphengine.descriptions.element_marks import called, marked
from graphengine.descriptions.engine import REFUSALS, body_names, collides, compiled, mujoco
from graphengine.descriptions.files.packages import Packages, package_of
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, document_text, mujoco_says
from graphengine.descriptions.geoms import extents
from graphengine.descriptions.mjcf.mjcf import read_mjcf
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.robot_files.mjcf_parts import add_model_parts
from graphengine.descriptions.robot_files.stage_parts import add_stage_parts
from graphengine.descriptions.robot_files.writer import render
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.descriptions.xacro.xacro import is_xacro
from graphengine.descriptions.xacro.xacro_macros import literal
from graphengine.devices.rotation import NOWHERE
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Document
from graphengine.format.files import shipped
from graphengine.physics.dynamics.keyframes import begin_in
from graphengine.physics.model.mesh_units import check_mesh_units
from graphengine.physics.model.robot import RobotInstance
from graphengine.physics.model.robot_prims import add_robot


def _check_self_view(draft: Draft) -> None:
    """Let ray sensors see through their own robot if it blocks them; the import of the simulation takes time."""
    if draft.sensors:
        from graphengine.bringup.robots.self_view import check_self_view

        check_self_view(draft)


_PARTS = (
    find_wheels,
    add_link_settings,
    fix_arm,
    add_drivetrain,
    add_joint_dynamics,
    set_gains,
    report_weak_wheels,
    add_wheel_material,
    add_rest,
    add_sensors,
    _check_self_view,
    report_unused,
)
"""Functions that add to a draft from a URDF description, in order of execution."""
_PARTS_OF_STAGES = (find_wheels, add_stage_parts, *_PARTS[2:9], _check_self_view, report_unused)
"""Functions that add to a draft from a USD stage, in order of execution."""
_PARTS_OF_MODELS = (find_wheels, add_model_parts, add_drivetrain, add_wheel_material, add_rest)
"""Functions that add to a draft from a MuJoCo model, in order of execution; fewer, because the model defines more itself."""
_MESHES = ("mesh", "texture")


@dataclass(frozen=True, slots=True)
class Origin:
    """The description to import, and the path of the robot file to write.

    Attributes:
        element: root element of the description after xacro expansion.
        packages: packages with the meshes of the description.
        path: path of the description's file; None if the import writes this file, because xacro has expanded the description or
            a topic has delivered it.
        told: origin of the description, as text for messages.
        target: path of the robot file to write.
        fixed_base: whether the root link is fixed to the world.
        bundled: whether the description, its meshes and the included graphs are copied into the project; then `path` is None.
        wrapper: text of a xacro file that calls a macro as the robot; empty without a macro.
        controllers: ros2_control parameter file that the user names; None without one.
        model: path of a MuJoCo model or a USD stage, whose root element is `element`; None for other descriptions.
        stage: description of the robot of a USD stage; None for other descriptions.
        choice: keys of the robot file that say what to read of the stage.
        stage_name: name of the folder for copies of the stage's files; empty for that of the robot.
        commanded: whether graphs outside of the robot command it; the import then adds none.
        position_drives: whether joints that take efforts get position drives to hold them.
    """

    element: Element
    packages: Packages
    path: Path | None
    told: str
    target: Path
    fixed_base: bool
    bundled: bool = False
    wrapper: str = ""
    controllers: Document | None = None
    model: Path | None = None
    position_drives: bool = False
    stage: RobotDescription | None = None
    choice: dict[str, Any] = field(default_factory=dict)
    stage_name: str = ""
    commanded: bool = False


@dataclass(frozen=True, slots=True)
class Imported:
    """An imported robot that compiles without errors, and the files to write for it.

    Attributes:
        robot: the robot as an instance in a scene.
        free: whether the root link can move.
        lowest: height (m) of the lowest point of the colliders above the root link, or above the origin of a MuJoCo model, with
            all joints at their start positions; None without colliders.
        library: library with the robot's meshes.
        files: a dict from the paths of files to write to their texts; the robot file is last.
        copies: a dict from the destinations of files to copy to their sources.
        outside: folders outside of the robot file's project that the robot uses; scenes need `--allow` for them.
        use: path of the robot file, as written in a scene of its project.
        draft: draft of the robot file, with remarks.
    """

    robot: RobotInstance
    free: bool
    lowest: float | None
    library: Library
    files: dict[Path, str]
    copies: dict[Path, Path]
    outside: list[Path]
    use: str
    draft: Draft

    @property
    def lift(self) -> float:
        """Height (m) of the root link at which the robot stands on a floor, rounded up to 1 mm.

        The height is 0 for a robot with a fixed base, and for a robot that starts in a keyframe, because keyframes have heights.
        """
        return 0.0 if not self.free or "start" in self.draft.settings else self._depth

    @property
    def rise(self) -> float:
        """Height (m), rounded up to 1 mm, that lifts all colliders of a robot with a fixed base above its place; else 0."""
        return 0.0 if self.free else max(0.0, self._depth)

    @property
    def _depth(self) -> float:
        """Distance from the root link down to the lowest point of the colliders, rounded up to 1 mm, m."""
        return math.ceil(round(-(self.lowest or 0.0), 4) * 1000) / 1000


def import_robot(origin: Origin, findings: Findings) -> Imported | None:
    """Create a robot file for a description and compile the robot, without writing files.

    After an error, add it to `findings` and return None.
    """
    written_to = origin.target.with_suffix(".urdf")
    if origin.model is None and add_mimics(origin.element, findings) and origin.path is not None:
        beside = origin.path.resolve() == written_to.resolve()
        written_to = origin.target.with_suffix(".imported.urdf") if beside else written_to
        origin = replace(origin, path=None)
    name, folder, files = origin.target.stem, origin.target.parent, origin.packages.files
    library = Library(files, findings)
    model_files: dict[Path, Path] = {}
    if origin.stage is not None and origin.stage.usd is not None:
        description: RobotDescription | None = origin.stage
        model_files = bundle_stage(origin.stage.usd.files, origin.stage_name or name) if origin.bundled else {}
    elif origin.model is None:
        description = read_urdf(origin.element, origin.packages, findings)
    else:
        description = read_mjcf(origin.model, library)
        model_files = bundle_model(origin.model, library, name) if origin.bundled else {}
    if description is None:
        return None
    packages = [] if origin.bundled else list(_used_packages(description))
    path = origin.path or written_to
    if origin.model is not None:
        copied = next((to for to, source in model_files.items() if source == origin.model.resolve()), None)
        path = folder / copied if copied is not None else origin.model
    told = [_near(each, origin.target) for each in packages]
    near = _near(path, origin.target)
    draft = Draft(description, name, origin.told, near, told)
    draft.fixed_base, draft.position_drives = origin.fixed_base, origin.position_drives
    draft.controllers, draft.library, draft.choice = origin.controllers, library, origin.choice
    parts = _PARTS if origin.model is None else _PARTS_OF_STAGES if origin.stage is not None else _PARTS_OF_MODELS
    for add_part in parts:
        add_part(draft)
    draft.settle()
    if origin.commanded:
        draft.graphs.clear()
    graphs = bundle_graphs(draft) if origin.bundled else {}
    document = render(draft, origin.target)
    checked = checked_spec(draft, library, str(origin.target), document)
    model = _compiled(checked[0], draft, findings) if checked is not None else None
    if checked is None or model is None:
        return None
    robot = checked[1]
    check_mesh_units(model, [("", robot)], findings)
    bodies = {f"{name}/{body}" for body in body_names(model)}
    before = len(findings.errors)
    add_robot(Stage(), robot, bodies, findings)
    if len(findings.errors) > before:
        return None
    meshes = bundle_meshes(description) if origin.bundled and origin.model is None else model_files
    written = {origin.target.with_suffix(WRAPPER): origin.wrapper} if origin.wrapper else {}
    if origin.path is None and origin.model is None:
        written[path] = _portable(description, meshes, path.parent)
    return Imported(
        robot=robot,
        free=robot.disabled.free_link is not None,
        lowest=_lowest(model, robot),
        library=library,
        files={**written, origin.target: "\n".join(document.source.lines)},
        copies={Path(os.path.normpath(folder / target)): source for target, source in {**graphs, **meshes}.items()},
        outside=_outside([*packages, path], origin),
        use=os.path.relpath(origin.target.parent.resolve() / origin.target.name, _project(origin.target)),
        draft=draft,
    )


def _compiled(spec: mujoco.MjSpec, draft: Draft, findings: Findings) -> mujoco.MjModel | None:
    description = draft.description
    try:
        model, told = compiled(spec)
    except REFUSALS as error:
        message, name, _ = mujoco_says(error)
        if (known := marked(error, [description.element])) is not None:
            findings.add("S106", f"MuJoCo: {message}: {called(known) or name!r}", known.span)
            return None
        owners = (name, name.rsplit(".", 2)[0])  # geoms are named LINK.NUMBER.NUMBER
        places = (element.span for element in description.element.walk() if element.get("name") in owners)
        findings.add("S106", f"MuJoCo: {message}: {name!r}", next(places, description.element.span))
        return None
    for text in draft.mujoco_warnings | dict.fromkeys(told):
        findings.add("W205", f"MuJoCo: {text}", description.element.span)
    return model


def _lowest(model: mujoco.MjModel, robot: RobotInstance) -> float | None:
    """Return the height (m) of the lowest point of the colliders above the root link, or above the origin of a MuJoCo model.

    This height is usually negative. Return None without colliders.
    """
    data = mujoco.MjData(model)
    if robot.keyframe is not None:
        begin_in(robot.keyframe, "", NOWHERE, model, data)
    mujoco.mj_kinematics(model, data)
    found = extents(model, data, np.flatnonzero(collides(model)))
    return float(found[0][2]) if found is not None else None


def _used_packages(description: RobotDescription) -> Iterator[Path]:
    """Yield the folder of each package with meshes of the robot, except for installed packages."""
    meshes = (element.get("filename") for element in description.element.walk() if element.tag in _MESHES)
    names = dict.fromkeys(name for reference in meshes if (name := package_of(reference)) is not None)
    for name in names:
        folder = description.packages.find(name)
        if folder is not None and not any(folder.is_relative_to(i) for i in description.packages.files.installed):
            yield folder.resolve()


def _portable(description: RobotDescription, beside: Collection[Path], folder: Path) -> str:
    """Return the text of the description for a file in the given folder.

    Relative references become absolute, unless the files are copied beside the description and have their paths in `beside`.
    Absolute paths, as xacro writes them for `$(find NAME)`, become references to packages or relative paths.
    """
    escaped = is_xacro(Path("robot.urdf"), description.element)  # the written file would be expanded again
    for element in description.element.walk():
        reference = element.get("filename")
        if element.tag in _MESHES and reference and "://" not in reference and Path(reference) not in beside:
            element.attributes["filename"] = (description.packages.folder / reference).resolve().as_uri()
        element.text = description.packages.reference(element.text, folder)
        if escaped:
            element.text = literal(element.text)
            element.attributes |= {name: literal(value) for name, value in element.attributes.items()}
    return document_text(description.element)


def _near(path: Path, target: Path) -> str:
    """Return a path for the robot file `target`: relative to this file if the path is in the project, else absolute."""
    resolved, folder = path.resolve(), target.parent.resolve()
    return os.path.relpath(resolved, folder) if resolved.is_relative_to(_project(target)) else str(resolved)


def _project(target: Path) -> Path:
    """Return the folder of the project: the folder of the robot file, or its parent if that folder is called `robots`."""
    folder = target.parent.resolve()
    return folder.parent if folder.name == "robots" else folder


def _outside(paths: list[Path], origin: Origin) -> list[Path]:
    """Return the folders of the given paths that scenes of the project may read only with `--allow`."""
    known = [_project(origin.target), shipped() / "scenes", *origin.packages.files.installed]
    found: list[Path] = []
    for path in paths:
        if not any(path.resolve().is_relative_to(folder) for folder in (*known, *found)):
            found.append(path.resolve() if path.is_dir() else path.resolve().parent)
    return found
