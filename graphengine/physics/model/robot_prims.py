"""Defines the prims of a robot: its links, joints, materials, frames and sensors.

Frames and mounts of sensors exist only as prims, not in physics; their poses follow from the bodies that carry them.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

from graphengine.devices.rotation import from_orientation
from graphengine.devices.stage import Prim, PrimKind, Stage
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.errors import AmbiguousPrimError, PrimError
from graphengine.format.prim_paths import prim_name
from graphengine.format.robot_spec import MaterialSpec, SensorSpec
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.implementations import Profile
from graphengine.physics.model.holonomic_wheels import holonomic_wheels
from graphengine.physics.model.profiles import RigProfile
from graphengine.physics.model.robot import RobotInstance


def within(stage: Stage, robot: str, reference: str) -> Prim:
    """Return the prim to which a robot file refers by a path below the robot's prim, or by a name that is unique in the robot.

    Args:
        stage: stage with the robot's prims.
        robot: path of the robot's prim.
        reference: path or name of the prim.

    Raises:
        PrimError: there is no such prim.
        AmbiguousPrimError: several prims have the name.
    """
    path = f"{robot}/{reference}"
    if path in stage and stage.is_literal(path, found := stage.find(path)):
        return found
    prims = list(stage.find(robot).descendants())
    named = [prim for prim in prims if prim.name == reference]
    if len(named) > 1:
        paths = [prim.path.removeprefix(f"{robot}/") for prim in named]
        text = f"{reference!r} could mean {len(named)} prims"
        raise AmbiguousPrimError(text, reference, listing(paths, "write one of"))
    if not named:
        names = {prim.name for prim in prims if prim.kind != "scope"}
        near = did_you_mean(reference, names) or listing(sorted(names), "prims")
        below = reference.removeprefix("/").partition("/")[2]
        if reference.startswith("/") and below and f"{robot}/{below}" in stage:
            near = f"paths in a robot file start below the robot: {below}"
        raise PrimError(f"the robot has no prim {reference!r}", reference, near)
    return named[0]


def add_robot(stage: Stage, robot: RobotInstance, bodies: Collection[str], findings: Findings) -> None:
    """Define the prims of a robot.

    Args:
        stage: stage to which the prims are added.
        robot: checked robot.
        bodies: names of the bodies in the physics model; a link without a body is only a frame.
        findings: receives errors for references to prims that do not exist or are ambiguous.
    """
    _PrimBuilder(stage, robot, bodies, findings).build()


class _PrimBuilder:
    def __init__(self, stage: Stage, robot: RobotInstance, bodies: Collection[str], findings: Findings) -> None:
        self.stage = stage
        self.robot = robot
        self.bodies = bodies
        self.findings = findings

    def build(self) -> None:
        """Define the prims of the robot, its frames, sensors and materials, and set namespaces and name overrides of prims."""
        robot, file = self.robot, self.robot.file
        links, keyframe = self._links(), robot.keyframe
        floating = [joint for joint in robot.description.joints.values() if joint.type == "floating"]
        self.stage.find(robot.prim_path).facts.update(
            base_link=links[robot.spec.base_link],
            articulation_root=links[robot.articulation_root],
            joints=tuple(joint.name for joint in robot.moving),
            moving_links=tuple(links[joint.child] for joint in (*robot.moving, *floating)),
            prismatic=tuple(joint.type == "prismatic" for joint in robot.moving),
            ranges=tuple(joint.limits or (-math.inf, math.inf) for joint in robot.moving),
            max_velocities=tuple(joint.velocity or math.inf for joint in robot.moving),
            leaders=tuple(joint.mimic.leader if joint.mimic is not None else "" for joint in robot.moving),
            wheel_radii=robot.wheel_radii,
            wheel_distance=robot.wheel_distance,
            holonomic_wheels=tuple(holonomic_wheels(robot)),
            urdf=robot.urdf_text,
            fixed_transforms=robot.fixed_transforms,
            **({"actuators": robot.actuators, "other_actuators": robot.other_actuators} if robot.actuators else {}),
            keyframes=robot.description.keyframes,
            **({"keyframe": keyframe} if keyframe is not None else {}),
        )
        self._joints(links)
        for name, frame in robot.spec.frames.items():
            pose = {"position": frame.position, "orientation": from_orientation(frame.orientation)}
            self._mount("frames", name, "frame", frame.parent, pose)
        mounts = {name: self._sensor(name, sensor) for name, sensor in robot.spec.sensors.items()}
        self.stage.find(robot.prim_path).facts["mounts"] = mounts
        for reference, value in robot.spec.namespaces.items():
            self._write("namespaces", reference, "namespace", value)
        if robot.placement.namespace is not None:
            self.stage.find(links[robot.spec.base_link]).namespace = robot.placement.namespace
        for reference, value in robot.spec.name_overrides.items():
            self._write("name_overrides", reference, "name_override", value)
        for name, material in robot.spec.materials.items():
            path, span = f"{robot.prim_path}/Materials/{name}", file.key_span("materials", name)
            facts = material.model_dump() | self._binding(material, links)
            self._add(path, "material", span, facts=facts)

    def _binding(self, material: MaterialSpec, links: dict[str, str]) -> dict[str, Any]:
        """Return the facts of a material's prim about its use: `floor`, `bodies` and `frames`.

        `floor` is the friction of the floor. `bodies` is a dict from each body with the material to whether the body is a wheel.
        For a material with a direction, `frames` is a dict from each body to the path of the link in whose frame the direction is
        given. A link that is the world itself is left out, because its colliders cannot be told apart from the colliders of the
        world.
        """
        wheels, name = self.robot.spec.wheel_colliders, self.robot.name
        bodies = {f"{name}/{link}": link in wheels for link in material.bind if f"{name}/{link}" in self.bodies}
        frames = {
            f"{name}/{link}": links[material.expressed_in or self.robot.description.turns_in(link)]
            for link in material.bind
            if material.direction is not None and f"{name}/{link}" in bodies
        }
        return {"floor": self.robot.floor, "bodies": bodies, "frames": frames}

    def _add(self, path: str, kind: PrimKind, span: Span, **facts: Any) -> Prim | None:
        try:
            return self.stage.add(path, kind, **facts)
        except PrimError as error:
            self.findings.add("S105", error.message, span, *error.help)
            return None

    def _links(self) -> dict[str, str]:
        """Define the prims of the robot and its links; return a dict from link name to prim path."""
        robot = self.robot
        base = f"{robot.name}/{robot.spec.base_link}"
        position, orientation = robot.placement.pose
        body = base if base in self.bodies else None
        pose = {"position": position, "orientation": orientation}
        self.stage.add(robot.prim_path, "robot", **pose, body=body, facts={"name": robot.name})
        paths: dict[str, str] = {}
        for link in robot.description.depth_first():
            name = prim_name(link.name)
            above = paths[link.carrier.parent] if link.carrier else f"{robot.prim_path}/Geometry"
            position, orientation = link.carrier.pose if link.carrier else ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
            body = f"{robot.name}/{link.name}"
            paths[link.name] = f"{above}/{name}"
            self._add(
                paths[link.name],
                "link",
                link.element.place("name"),
                position=position,
                orientation=orientation,
                body=body if body in self.bodies else None,
                name_override="" if name == link.name else link.name,
                facts={"link": link.name},
            )
        return paths

    def _joints(self, links: dict[str, str]) -> None:
        starts = self.robot.starts
        for joint in self.robot.description.joints.values():
            name = prim_name(joint.name)
            self._add(
                f"{self.robot.prim_path}/Physics/{name}",
                "joint",
                joint.element.place("name"),
                name_override="" if name == joint.name else joint.name,
                facts={
                    "joint": joint.name,
                    "type": joint.type,
                    "enabled": joint.name not in self.robot.disabled.joints,
                    "parent": links[joint.parent],
                    "child": links[joint.child],
                    "drive": self.robot.drives.get(joint.name),
                    "leader": joint.mimic.leader if joint.mimic is not None else "",
                    "effort": joint.effort,
                    **({"start": starts[joint.name]} if joint.name in starts else {}),
                },
            )

    def _mount(self, section: str, name: str, kind: PrimKind, parent: str, pose: dict[str, Any], **facts: Any) -> str:
        """Define a prim below the parent to which the robot file refers; return the prim's path, empty after an error."""
        file = self.robot.file
        try:
            above = within(self.stage, self.robot.prim_path, parent)
        except PrimError as error:
            self.findings.add("S104", error.message, file.span(section, name, "parent"), *error.help)
            return ""
        prim = self._add(f"{above.path}/{name}", kind, file.key_span(section, name), facts=facts, **pose)
        return prim.path if prim is not None else ""

    def _write(self, section: str, reference: str, attribute: str, value: str) -> None:
        try:
            setattr(within(self.stage, self.robot.prim_path, reference), attribute, value)
        except PrimError as error:
            self.findings.add("S104", error.message, self.robot.file.key_span(section, reference), *error.help)

    def _sensor(self, name: str, sensor: SensorSpec) -> str:
        """Define the prims of a sensor; return the path of its device, or of the mount that carries its devices."""
        profile = self.robot.profiles.get(name)
        pose = {"position": sensor.position, "orientation": from_orientation(sensor.orientation)}
        given = profile.devices() if profile is not None else []
        if given and not given[0][0].child:
            [(device, figures)] = given
            return self._mount("sensors", name, device.kind, sensor.parent, pose, **_facts(figures, sensor))
        path = self._mount("sensors", name, "sensor", sensor.parent, pose, type=sensor.type)
        span = self.robot.file.key_span("sensors", name)
        for device, figures in given if path else ():
            place = f"{path}/{device.child}"
            self._add(place, device.kind, span, orientation=device.orientation, facts=_facts(figures, sensor))
        if path and profile is not None and profile.rig is not None:
            self._rig(path, profile.rig, sensor, span)
        return path

    def _rig(self, path: str, rig: RigProfile, sensor: SensorSpec, span: Span) -> None:
        housing = f"{path}/{rig.housing}"
        self._add(housing, "sensor", span)
        for name, part in rig.parts.items():
            pose = {"position": part.position, "orientation": from_orientation(part.orientation)}
            for device, profile in part.devices():
                self._add(f"{housing}/{name}", device.kind, span, facts=_facts(profile, sensor), **pose)


def _facts(figures: Profile, sensor: SensorSpec) -> dict[str, Any]:
    """Return the facts of a sensor's profile and the keys of the robot file; its `noise_std` overrides that of the profile."""
    facts = figures.facts()
    if figures.casts_rays:
        facts |= {"sees_own_robot": sensor.sees_own_robot, "ignores": sensor.ignores}
    if "noise_std" in facts and sensor.noise_std is not None:
        facts["noise_std"] = sensor.noise_std
    return facts
