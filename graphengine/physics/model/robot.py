"""Loads a robot of a scene: its description with the changes in its robot file. All names are checked; physics is not built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from graphengine.descriptions.actuators.drives import Drive, drive_of, in_si
from graphengine.descriptions.actuators.mjcf_actuators import drives_by_joint
from graphengine.descriptions.actuators.mjcf_model import Keyframe
from graphengine.descriptions.description_reader import read_description
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.robot_description import TURNING, Joint, RobotDescription, track
from graphengine.descriptions.robot_files.robot_file import RobotFile
from graphengine.descriptions.shapes import kind_of
from graphengine.descriptions.urdf.urdf_writer import description_text
from graphengine.devices.rotation import Quaternion, Vector3, rotate
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.robot_spec import RobotSpec, WheelColliderSpec
from graphengine.format.wording import listing
from graphengine.physics.model.fleet_expansion import RobotPlacement
from graphengine.physics.model.joint_disabling import Disabled, disable_joints
from graphengine.physics.model.joint_starts import check_known, check_starts
from graphengine.physics.model.materials import NO_FLOOR_FRICTION
from graphengine.physics.model.profiles import SensorProfile, read_profiles

_LEVEL = 1e-3
"""Minimum length of the horizontal part of a friction direction, divided by the length of the direction."""


@dataclass(slots=True, eq=False, repr=False)
class RobotInstance:
    """A robot of a scene.

    Attributes:
        placement: name, pose and namespace of the robot in the scene.
        file: robot file, merged with the files that it extends.
        description: robot description, with the joint origins and limits of the robot file applied.
        urdf_text: the same description as XML, for robot_state_publisher.
        profiles: a dict from sensor name to the profile of the sensor.
        moving: moving joints, in order of the articulation.
        drives: a dict from the name of a moving joint to its drive; joints without a drive are absent.
        disabled: disabled joints, and the link that moves freely as a result.
        floor: friction coefficient of the floor.
    """

    placement: RobotPlacement
    file: RobotFile
    description: RobotDescription
    urdf_text: str
    profiles: dict[str, SensorProfile]
    moving: tuple[Joint, ...]
    drives: dict[str, Drive]
    disabled: Disabled
    floor: float = NO_FLOOR_FRICTION

    @property
    def name(self) -> str:
        """Name of the robot in the scene; it is also the prefix of the robot's names in the physics model."""
        return self.placement.name

    @property
    def spec(self) -> RobotSpec:
        """The contents of the robot file, merged with the files that it extends."""
        return self.file.spec

    @property
    def prim_path(self) -> str:
        """Path of the robot's prim."""
        return self.placement.prim_path

    @property
    def articulation_root(self) -> str:
        """Name of the link whose prim graphs name to address the robot."""
        return self.spec.articulation_root or self.disabled.free_link or self.spec.base_link

    @property
    def fixed_transforms(self) -> tuple[tuple[str, str, Vector3, Quaternion], ...]:
        """Parent frame, child frame, translation (m) and rotation of each fixed joint, in order of the description."""
        fixed = [joint for joint in self.description.joints.values() if joint.type == "fixed"]
        return tuple((joint.parent, joint.child, *joint.pose) for joint in fixed)

    @property
    def starts(self) -> dict[str, float]:
        """A dict from the name of a moving joint to its start position (rad or m); joints without a start position are absent.

        The scene overrides the robot file, which overrides the keyframe. For a mimic joint without a start position, the position
        follows from that of its leader.
        """
        known, keyframe = {joint.name: joint for joint in self.moving}, self.keyframe
        coordinates = keyframe.coordinates if keyframe is not None else {}
        stated = {name: coordinates[name][0] for name in known if name in coordinates}
        stated |= {name: joint.start for name, joint in self.spec.joints.items() if joint.start is not None}
        stated |= {name: joint.start for name, joint in self.placement.use.joints.items()}
        starts = {name: stated[name] for name in known if name in stated}
        pending = {name: joint.mimic for name, joint in known.items() if joint.mimic is not None and name not in starts}
        while followers := [name for name, mimic in pending.items() if mimic.leader in starts]:
            for name in followers:
                mimic = pending.pop(name)
                starts[name] = mimic.multiplier * starts[mimic.leader] + mimic.offset
        return starts

    @property
    def keyframe(self) -> Keyframe | None:
        """The keyframe of the robot's MuJoCo model in which the robot starts; None if it starts in no keyframe."""
        name = self.placement.use.start or self.spec.start
        return self.description.keyframes.get(name or "")

    @property
    def actuators(self) -> dict[str, str]:
        """A dict from the name of each actuator of the MuJoCo model to the name of its joint; an empty name for other targets.

        Actuators are left out if they have the name of a joint, or if the robot file replaces them by a drive.
        """
        joints = {joint.name for joint in self.moving}
        own = [actuator for actuator in self.description.actuators if actuator.name not in joints]
        driven = {actuator.joint: self.drives.get(actuator.joint, Drive()).servos for actuator in own}
        return {each.name: each.joint for each in own if not each.joint or driven[each.joint] is not None}

    @property
    def other_actuators(self) -> dict[str, Drive]:
        """A dict from actuator name to drive, for actuators of the MuJoCo model that do not act on one hinge or slide joint."""
        known = {each.name: each.drive for each in self.description.actuators}
        return {name: known[name] for name, joint in self.actuators.items() if not joint}

    @property
    def wheel_radii(self) -> dict[str, float]:
        """A dict from the name of each moving joint that carries a wheel to the radius of the wheel, m."""
        return {wheel.joint: wheel.radius for wheel in self.description.wheels(self.moving, wheel_shapes(self.spec))}

    @property
    def wheel_distance(self) -> float | None:
        """Distance (m) along the axle between the centres of the two driven wheels.

        None unless exactly two wheels with different centres are driven, and neither slides sideways. A base whose wheels slide
        sideways turns like a base with a greater wheel distance.
        """
        sliding = {link for each in self.spec.materials.values() if each.steady_sliding for link in each.bind}
        joints = [joint for joint in self.moving if joint.name in self.drives]
        driven = self.description.wheels(joints, wheel_shapes(self.spec))
        slides = any(self.description.joints[wheel.joint].child in sliding for wheel in driven)
        return track(driven) if len(driven) == 2 and not slides else None


def wheel_shapes(spec: RobotSpec) -> dict[str, tuple[float, float]]:
    """Return a dict from link to radius and offset along the axle (m), for wheels with colliders of the robot file."""
    shapes = spec.wheel_colliders.items()
    return {link: (shape.radius, shape.offset) for link, shape in shapes if isinstance(shape, WheelColliderSpec)}


def load_robot(
    placement: RobotPlacement, file: RobotFile, library: Library, description: RobotDescription | None = None
) -> RobotInstance | None:
    """Check a robot file against its description and return the robot; None after an error.

    Args:
        placement: name, pose and namespace of the robot.
        file: robot file.
        library: reads the files to which the robot refers; its findings receive errors and notes.
        description: description of the robot; by default it is read according to the robot file.
    """
    findings = library.findings
    description = description or read_description(file, library)
    profiles = read_profiles(file, library.files, findings)
    if description is None:
        return None
    before = len(findings.errors)
    _check_names(file, description, findings)
    _check_senses(file, description, profiles, findings)
    _check_model(file, description, findings)
    if len(findings.errors) > before:
        return None
    for name, joint in file.spec.joints.items():
        if joint.position is not None:
            description.joints[name].pose = joint.position, description.joints[name].pose[1]
        if joint.limits is not None:
            _limit(name, joint.limits, file, description, findings)
    disabled = disable_joints(file, description, findings)
    drives = _drives(file, description, disabled, findings)
    _check_colliders(file, description, findings)
    _check_joints(file, description, disabled, findings)
    _check_directions(file, description, findings)
    urdf_text, moving = description_text(description), tuple(description.moving())
    return RobotInstance(placement, file, description, urdf_text, profiles, moving, drives, disabled)


def _check_names(file: RobotFile, description: RobotDescription, findings: Findings) -> None:
    spec = file.spec
    if spec.base_link != description.root:
        text = f"{spec.base_link!r} is not the root link of the description"
        findings.add("S104", text, file.span("base_link"), f"write base_link: {description.root}")
    if spec.articulation_root:
        check_known("link", spec.articulation_root, description.links, file.span("articulation_root"), findings)
    for link in spec.links:
        check_known("link", link, description.links, file.key_span("links", link), findings)
    for joint in spec.joints:
        check_known("joint", joint, description.joints, file.key_span("joints", joint), findings)
    for index, joint in enumerate(spec.keep_only_joints):
        check_known("joint", joint, description.joints, file.span("keep_only_joints", index), findings)
    for link in spec.wheel_colliders:
        check_known("link", link, description.links, file.key_span("wheel_colliders", link), findings)
    bound: dict[str, Span] = {}
    for name, material in spec.materials.items():
        if material.expressed_in:
            span = file.span("materials", name, "expressed_in")
            check_known("link", material.expressed_in, description.links, span, findings)
        for index, link in enumerate(material.bind):
            span = file.span("materials", name, "bind", index)
            check_known("link", link, description.links, span, findings)
            if link in bound:
                findings.add("S105", f"link {link!r} has two materials", span, related=[(bound[link], "first here")])
            bound[link] = span


def _check_senses(
    file: RobotFile, description: RobotDescription, profiles: Mapping[str, SensorProfile], findings: Findings
) -> None:
    """Add errors for links in `ignores` that do not exist, and for keys of rays in sensors that cast none."""
    for name, sensor in file.spec.sensors.items():
        for index, link in enumerate(sensor.ignores):
            check_known("link", link, description.links, file.span("sensors", name, "ignores", index), findings)
        if name not in profiles or any(profile.casts_rays for profile in profiles[name].all_devices()):
            continue
        for key in ("sees_own_robot", "ignores"):
            if key in sensor.model_fields_set:
                text = f"{key}: has no effect, because a sensor of type {sensor.type} casts no rays"
                findings.add("G109", text, file.key_span("sensors", name, key), "remove the key")


def _check_model(file: RobotFile, description: RobotDescription, findings: Findings) -> None:
    """Add errors for an unknown start keyframe, and for keys that have no effect on a MuJoCo model."""
    spec = file.spec
    if spec.start:
        check_known("keyframe", spec.start, description.keyframes, file.span("start"), findings)
    if description.mjcf is None:
        return
    places = {key: file.key_span(key) for key in ("keep_only_joints", "self_collision") if getattr(spec, key)}
    for name, joint in spec.joints.items():
        given = {"enabled": not joint.enabled, "weld": joint.weld, "position": joint.position is not None}
        places |= {key: file.key_span("joints", name, key) for key, is_given in given.items() if is_given}
    for key, span in places.items():
        findings.add("G109", f"{key}: has no effect on a MuJoCo model", span, "change the file of the model instead")


def _drives(file: RobotFile, description: RobotDescription, disabled: Disabled, findings: Findings) -> dict[str, Drive]:
    """Return a dict from the name of a moving joint to its drive, from the robot file or an actuator of a MuJoCo model."""
    drives: dict[str, Drive] = {}
    for name, spec in file.spec.joints.items():
        joint = description.joints[name]
        drive = drive_of(spec, joint.effort or math.inf, prismatic=joint.type == "prismatic")
        if drive is None or name in disabled.joints:
            continue
        key = "drive" if spec.drive is not None else "usd_drive"
        span = file.key_span("joints", name, key)
        if not joint.moves:
            findings.add("S104", f"joint {name!r} is fixed: a drive cannot move it", span, "remove the drive")
            continue
        if not (drive.damping or drive.stiffness):
            advice = "damping acts on velocity targets, stiffness on position targets; efforts need no drive"
            findings.add("N103", f"joint {name!r}: a drive without damping and stiffness does nothing", span, advice)
            continue
        drives[name] = drive
        if spec.usd_drive is not None and joint.type != "prismatic":
            text = f"joint {name!r}: usd_drive is given per degree; in SI units it is {in_si(drive)}"
            findings.add("N103", text, span)
    if description.mjcf is not None:
        drives = drives_by_joint(description.mjcf.actuators) | drives
        drives = {name: drives[name] for name, joint in description.joints.items() if joint.moves and name in drives}
    wheels = description.wheels((description.joints[name] for name in drives), wheel_shapes(file.spec))
    for wheel in wheels:
        drives[wheel.joint] = replace(drives[wheel.joint], carries=wheel.radius**2 / len(wheels))
    return drives


def _limit(
    name: str, limits: tuple[float, float], file: RobotFile, description: RobotDescription, findings: Findings
) -> None:
    joint = description.joints[name]
    if joint.type in ("revolute", "prismatic"):
        joint.bounds = replace(joint.bounds, lower=limits[0], upper=limits[1])
    else:
        span = file.span("joints", name, "limits")
        findings.add("S104", f"joint {name!r} is {joint.type} and cannot have limits", span)


def _check_joints(file: RobotFile, description: RobotDescription, disabled: Disabled, findings: Findings) -> None:
    """Add errors for start positions that joints cannot have, and for springs on joints that do not move."""
    joints = file.spec.joints
    stated = {name: joint.start for name, joint in joints.items() if joint.start is not None}
    starts = {name: (start, file.span("joints", name, "start")) for name, start in stated.items()}
    check_starts(starts, description, disabled.joints, findings)
    for name, joint in joints.items():
        if joint.spring is not None and (not description.joints[name].moves or name in disabled.joints):
            span = file.key_span("joints", name, "spring")
            findings.add("S104", f"joint {name!r} does not move, so a spring has no effect", span)


def _check_directions(file: RobotFile, description: RobotDescription, findings: Findings) -> None:
    """Add an error for each material whose friction direction is perpendicular to the floor."""
    for name, material in file.spec.materials.items():
        if material.direction is None:
            continue
        for link in material.bind:
            frame = material.expressed_in or description.turns_in(link)
            x, y, z = rotate(description.pose_in_root(frame)[1], material.direction)
            if math.hypot(x, y) < _LEVEL * math.hypot(x, y, z):
                text = f"material {name!r}: its direction, along the z axis of {description.root!r}, is perpendicular to a floor"
                advice = f"give the direction along which it grips the floor with dynamic_friction, in the frame of {frame!r}"
                findings.add("S106", text, file.span("materials", name, "direction"), advice)
                break


def _check_colliders(file: RobotFile, description: RobotDescription, findings: Findings) -> None:
    for link, shape in file.spec.wheel_colliders.items():
        tags = [kind_of(collider.geometry) for collider in description.links[link].colliders]
        span = file.key_span("wheel_colliders", link)
        if shape == "ellipsoid" and tags != ["cylinder"]:
            text = f"link {link!r} cannot become an ellipsoid, because its collision geometry is not a single cylinder"
            size = "for another collider write {radius: …, width: …}, in m"
            findings.add("S106", text, span, listing(tags, "its colliders"), size)
        carrier = description.links[link].carrier
        if isinstance(shape, WheelColliderSpec) and (carrier is None or carrier.type not in TURNING):
            findings.add("S106", f"link {link!r} is not a wheel: no joint turns it", span)
    for name, material in file.spec.materials.items():
        for index, link in enumerate(material.bind):
            if not description.links[link].colliders:
                span = file.span("materials", name, "bind", index)
                findings.add("S104", f"link {link!r} has no collider to bind a material to", span)
