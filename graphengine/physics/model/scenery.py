"""Compiles the world of a scene with any set of robots; each robot file is read once."""

from __future__ import annotations

import copy
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from graphengine.descriptions.added_formats import tell_suffix
from graphengine.descriptions.description_reader import is_description, is_text, read_bare
from graphengine.descriptions.element_marks import called, marked
from graphengine.descriptions.engine import REFUSALS, all_bodies, compiled, mujoco
from graphengine.descriptions.files.bounds import ELEMENT, HOW_MEMORY_COUNTS, MAX_MEMORY, PAIR, TOO_LARGE
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element, mujoco_says, place_of
from graphengine.descriptions.robot_files.robot_file import read_robot
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.files import Files
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import Loaded
from graphengine.format.wording import listing
from graphengine.physics.model.fleet_expansion import RobotPlacement
from graphengine.physics.model.joint_starts import check_known, check_starts
from graphengine.physics.model.materials import NO_FLOOR_FRICTION
from graphengine.physics.model.robot import RobotInstance, load_robot
from graphengine.physics.model.robot_model import robot_spec
from graphengine.physics.model.sensor_bodies import add_sensors
from graphengine.physics.model.surface_joints import add_surface_joints
from graphengine.physics.model.world_model import tell_overridden

_DEGREE_OF_FREEDOM = re.compile(r"\bDOF (\d+)")


@dataclass(frozen=True, slots=True)
class _RobotKind:
    """A robot that was read from one file or text, and its MjSpec.

    `memory` is the estimated memory (see `bounds`) of its files and MjSpec, `each` that of a copy in a scene, bytes.
    """

    robot: RobotInstance
    model: mujoco.MjSpec
    memory: float
    each: float


class Scenery:
    """The world of a scene, and the robots that have been read for it.

    Args:
        scene: scene file, for locations in messages and as the start of relative paths.
        world: parsed world; None if parsing failed; then `compile` returns None.
        lines: source location of each line of the parsed text of the world.
        library: reads the files to which descriptions refer.
    """

    def __init__(
        self, scene: Loaded[SceneSpec], world: mujoco.MjSpec | None, lines: Sequence[Span], library: Library
    ) -> None:
        self.scene = scene
        self.library = library
        self._world = world
        self._lines = lines
        self._world_memory = library.memory
        self._floor = _floor_friction(world) if world is not None else NO_FLOOR_FRICTION
        self._kinds: dict[str, _RobotKind | None] = {}
        """A dict from the path of a file, or the text of a description, to the robot; None for a robot with errors."""

    def copy(self, files: Files) -> Scenery:
        """Return a copy that reads further robots from `files` independently of this one."""
        made = copy.copy(self)
        made.library, made._kinds = self.library.copy(files), dict(self._kinds)
        return made

    def robot(self, placement: RobotPlacement, findings: Findings) -> RobotInstance | None:
        """Return a robot for the given placement; None after an error.

        Each robot file is read once, and its errors are reported once.
        """
        use = placement.use.use
        if is_text(use):
            path, key = self.scene.folder / "description", use
        else:
            found = self.library.files.look_up(use, self.scene.folder, findings, self._place_of(placement), stages=True)
            if found is None:
                return None
            path, key = found, str(found)
        if key not in self._kinds:
            self._kinds[key] = self._read(path, placement, findings)
        kind = self._kinds[key]
        if kind is not None:
            self._check_starts(kind.robot, placement, findings)
        return replace(kind.robot, placement=placement, floor=self._floor) if kind is not None else None

    def _check_starts(self, robot: RobotInstance, placement: RobotPlacement, findings: Findings) -> None:
        """Check the start positions of a robot's joints in the scene, once for a fleet."""
        joints, document = placement.use.joints, self.scene.document
        if placement.use.start:
            span = document.span("robots", placement.key, "start")
            check_known("keyframe", placement.use.start, robot.description.keyframes, span, findings)
        if joints and placement.key and placement.name in (placement.key, f"{placement.key}_0000"):
            at = ("robots", placement.key, "joints")
            starts = {name: (joint.start, document.span(*at, name, "start")) for name, joint in joints.items()}
            check_starts(starts, robot.description, robot.disabled.joints, findings)

    def _place_of(self, placement: RobotPlacement) -> Span | None:
        """Return the source location of a robot's `use` in the scene; None for a robot that is added later."""
        return self.scene.document.span("robots", placement.key, "use") if placement.key else None

    def forget(self, robots: Mapping[str, RobotInstance]) -> None:
        """Discard robots with errors, and unused descriptions that were given as text."""
        used = {id(robot.file) for robot in robots.values()}
        self._kinds = {
            key: kind
            for key, kind in self._kinds.items()
            if kind is not None and (id(kind.robot.file) in used or not is_text(key))
        }

    def _read(self, path: Path, placement: RobotPlacement, findings: Findings) -> _RobotKind | None:
        self.library.findings = findings  # findings go to the present caller, not to the first one
        self.library.memory = before = self._memory()
        use, description = placement.use.use, None
        if is_text(use) or is_description(path):
            file, description = read_bare(use, path, self.library) or (None, None)
        else:
            file = read_robot(path, self.library.files, findings)
            if file is None:
                tell_suffix(path, self._place_of(placement), findings)
        robot = load_robot(placement, file, self.library, description) if file is not None else None
        model = robot_spec(robot, self.library, self._floor, findings) if robot is not None else None
        if robot is None or model is None:
            return None
        if robot.description.mjcf is not None and self._world is not None:
            tell_overridden(robot.description.mjcf.element, self._world, findings)
        if description is not None:
            self._tell_joints(robot, placement, findings)
        add_sensors(model, robot)
        each = ELEMENT * (len(model.bodies) + len(model.geoms)) + PAIR * len(model.excludes)
        return _RobotKind(robot, model, self.library.memory - before, each)

    def _memory(self) -> float:
        """Return the estimated memory of the world and of all robots that have been read, without their copies, bytes."""
        return self._world_memory + sum(kind.memory for kind in self._kinds.values() if kind is not None)

    def _tell_joints(self, robot: RobotInstance, placement: RobotPlacement, findings: Findings) -> None:
        """Add a note on the joints that graphs can use, for a description without a robot file."""
        floating = [joint.name for joint in robot.description.joints.values() if joint.type == "floating"]
        still = [joint.name for joint in robot.moving if joint.name not in robot.drives and joint.mimic is None]
        number, known = len(robot.moving) + len(floating), len(robot.moving) if floating else "all"
        count = f"{number} joint{'s' * (number != 1)}; graphs can use {known}" if number else "no joint that moves"
        lists: Mapping[str, Collection[str]] = {
            "ball and free joints, which graphs cannot use": floating,
            "joints without a drive": still,
            "keyframes, which `start:` can select": robot.description.keyframes,
        }
        text = f"the description, used without a robot file, has {count}"
        notes = [listing(names, what) for what, names in lists.items() if names]
        findings.add("N104", text, self._place_of(placement), *notes)

    def compile(
        self, robots: Mapping[str, RobotInstance], findings: Findings, surfaces: Collection[str] = ()
    ) -> mujoco.MjModel | None:
        """Compile the world with the given robots; return None if MuJoCo reports an error.

        Args:
            robots: a dict from name to a robot that `robot` returned.
            findings: receives errors and warnings of MuJoCo.
            surfaces: names of bodies that get a moving surface; unknown names are skipped.
        """
        whole = self._assembled(robots, findings)
        if whole is None:
            return None
        add_surface_joints(whole, surfaces)
        try:
            model, told = compiled(whole)
        except REFUSALS as error:
            self._refused(error, robots, findings)
            return None
        for text in told:
            self._warned(text, model, robots, findings)
        return model

    def _assembled(self, robots: Mapping[str, RobotInstance], findings: Findings) -> mujoco.MjSpec | None:
        """Return a copy of the world to which the robots are attached; None if MuJoCo reports an error.

        Robots share equal meshes and textures, because MuJoCo loads files with equal names once. Attaching a model renames the
        files that it contains; therefore the models contain no files, and the library provides all of them.
        """
        if self._world is None:
            return None
        kinds = {id(kind.robot.file): kind for kind in self._kinds.values() if kind is not None}
        if self._memory() + sum(kinds[id(robot.file)].each for robot in robots.values()) > MAX_MEMORY:
            span = self.scene.document.key_span("robots")
            findings.add("S106", f"the world and its robots ({len(robots)}) {TOO_LARGE}", span, *HOW_MEMORY_COUNTS)
            return None
        before, whole = len(findings.errors), self._world.copy()
        whole.assets.clear()
        for robot in robots.values():
            position, (x, y, z, w) = robot.placement.pose
            frame = whole.worldbody.add_frame(pos=position, quat=(w, x, y, z))
            # A copy, because an attached model belongs to the whole, and each attachment slows down MuJoCo's own copying.
            model = kinds[id(robot.file)].model.copy()
            model.assets.clear()
            if robot.description.mjcf is not None:
                model.option = whole.option  # or MuJoCo warns that they differ
            has_assets = bool(list(model.meshes) or list(model.textures))
            try:
                whole.attach(model, frame=frame, prefix=f"{robot.name}/")
            except REFUSALS as error:
                self._refused(error, robots, findings)
            if has_assets:  # after each robot, because attaching becomes slower with the number of assets
                whole.dedup_assets()
        whole.assets = self.library.assets
        return whole if len(findings.errors) == before else None

    def _warned(
        self, text: str, model: mujoco.MjModel, robots: Mapping[str, RobotInstance], findings: Findings
    ) -> None:
        """Report a warning of MuJoCo about a compiled model, located at the joint whose degree of freedom it names, if any."""
        number = _DEGREE_OF_FREEDOM.search(text)
        span, where = self.scene.document.key_span("world"), ""
        if number is not None and int(number[1]) < model.nv:
            index = int(model.dof_jntid[int(number[1])])
            name = model.joint(index).name or model.body(int(model.jnt_bodyid[index])).name
            where = f"degree of freedom {number[1]} belongs to {name!r}"
            span = element.span if (element := _element(name, robots)) is not None else span
        findings.add("W205", f"MuJoCo: {text}", span, where)

    def _refused(self, error: Exception, robots: Mapping[str, RobotInstance], findings: Findings) -> None:
        """Report an error of MuJoCo at the element of a robot's description that it names, else at a line of the world."""
        message, name, line = mujoco_says(error)
        known = marked(error, (robot.description.element for robot in robots.values()))
        element = known or _element(name, robots)
        if element is not None:
            user = (called(known) if known is not None else "") or name.partition("/")[2]
            findings.add("S106", f"MuJoCo: {message}: {user!r}", element.span)
        else:
            findings.add("S106", f"MuJoCo: {message}", place_of(self._lines, line))


def _element(name: str, robots: Mapping[str, RobotInstance]) -> Element | None:
    """Return the element to which a name `ROBOT/ELEMENT` refers; the root of the robot's description if it has no such element.

    Return None if the name does not begin with the name of a robot.
    """
    owner, _, rest = name.partition("/")
    if owner not in robots:
        return None
    root = robots[owner].description.element
    return next((element for element in root.walk() if element.get("name") == rest.partition(".")[0]), root)


def _floor_friction(world: mujoco.MjSpec) -> float:
    """Return the sliding friction of the world's first plane, or `NO_FLOOR_FRICTION` without one."""
    geoms = (geom for body in all_bodies(world) for geom in body.geoms)
    planes = (geom for geom in geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE)
    return next((float(geom.friction[0]) for geom in planes), NO_FLOOR_FRICTION)
