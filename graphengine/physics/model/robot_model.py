"""Builds the MjSpec of a checked robot; copies of it are attached to the world of a scene."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator

import numpy as np

from graphengine.descriptions.actuators.drives import Drive, servos
from graphengine.descriptions.actuators.mjcf_model import MjcfModel
from graphengine.descriptions.engine import PICTURES, RAYS, RAYS_AND_PICTURES, TIGHT_SOLIMP, TIGHT_SOLREF, mujoco
from graphengine.descriptions.files.bounds import MAX_MEMORY, PAIR
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.mujoco_writer import write_robot
from graphengine.descriptions.robot_description import WORLD, Mimic, RobotDescription
from graphengine.format.diagnostics import Findings
from graphengine.format.robot_spec import JointSpec, WheelColliderSpec
from graphengine.physics.model.materials import against_floor, sentences
from graphengine.physics.model.robot import RobotInstance

_HARD_SOLREF, _HARD_SOLIMP = (0.004, 1.0), (0.99, 0.999)
"""Solver parameters of joint limits. A drive of 1e4 N m/rad exceeds a limit by 0.3 mrad; with MuJoCo's defaults, by 40 mrad."""


def robot_spec(robot: RobotInstance, library: Library, floor: float, findings: Findings) -> mujoco.MjSpec | None:
    """Return the robot as an MjSpec; None after an error.

    Args:
        robot: robot whose file has been checked against its description.
        library: reads the meshes.
        floor: sliding friction of the floor.
        findings: receives errors and notes.
    """
    mjcf = robot.description.mjcf
    spec = _of_urdf(robot, library, findings) if mjcf is None else _of_mjcf(robot, mjcf)
    if spec is None:
        return None
    for link, changes in robot.spec.links.items():
        body = spec.body(link)  # None for a site of a MuJoCo model
        if body is not None and (mjcf is None or not changes.gravity):
            body.gravcomp = 0.0 if changes.gravity else 1.0
    _equip_joints(spec, robot)
    _shape_wheels(spec, robot)
    if mjcf is None:
        _hollow_meshes(spec)
        _group_geoms(spec, robot)
    _apply_materials(spec, robot, floor, findings)
    if mjcf is None:
        for first, second in _excluded_pairs(robot):
            spec.add_exclude(bodyname1=first, bodyname2=second)
        _prune(spec, robot)
    if robot.moving:
        _keep_awake(spec)
    return spec


def _of_mjcf(robot: RobotInstance, model: MjcfModel) -> mujoco.MjSpec:
    """Return a copy of a robot's MuJoCo model, with its root link fixed to the world if the robot file says so."""
    spec = model.spec.copy()
    if model.free and robot.disabled.free_link is None:
        spec.delete(next(iter(spec.body(robot.description.root).joints)))
    return spec


def _of_urdf(robot: RobotInstance, library: Library, findings: Findings) -> mujoco.MjSpec | None:
    """Return the MjSpec of a URDF description; None after an error.

    The freely moving link gets a free joint unless the base is fixed to the world.
    """
    free_link = robot.disabled.free_link
    colours = {name: link.colour for name, link in robot.spec.links.items() if link.colour is not None}
    more = _memory_of_exclusions(robot)
    spec = write_robot(
        robot.description, robot.name, library, findings, free_link=free_link, colours=colours, more=more
    )
    if spec is not None and free_link is not None:
        spec.body(free_link).add_freejoint(name=_unused("root", robot.description.joints))
    return spec


def _unused(name: str, taken: Collection[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _equip_joints(spec: mujoco.MjSpec, robot: RobotInstance) -> None:
    """Set limits, armatures and drives of joints, and couple mimic joints.

    In a MuJoCo model, only properties given in the robot file change; a drive replaces the joint's actuators.
    """
    for joint in robot.moving:
        driven, changes = spec.joint(joint.name), robot.spec.joints.get(joint.name, JointSpec())
        if robot.description.mjcf is None:
            driven.solref_limit, driven.solimp_limit[:2] = _HARD_SOLREF, _HARD_SOLIMP
            driven.armature = changes.armature if joint.name in robot.spec.joints else driven.armature
            if joint.mimic is not None:
                _tie(spec, joint.name, joint.mimic)
        else:
            driven.armature = changes.armature or driven.armature
            if changes.limits is not None:
                driven.range, driven.limited = changes.limits, mujoco.mjtLimited.mjLIMITED_TRUE
        drive = robot.drives.get(joint.name)
        if drive is not None and drive.servos is None:
            _delete_actuators(spec, robot, joint.name)
            _add_servos(spec, joint.name, drive)
        if changes.spring is not None:
            _add_spring(driven, changes.spring.stiffness, changes.spring.rest)


def _delete_actuators(spec: mujoco.MjSpec, robot: RobotInstance, joint: str) -> None:
    """Delete the actuators of a MuJoCo model that move a joint, and the sensors that measure them."""
    names = {actuator.name for actuator in robot.description.actuators if actuator.joint == joint}
    measured = [each for each in spec.sensors if each.objtype == mujoco.mjtObj.mjOBJ_ACTUATOR and each.objname in names]
    for part in (*measured, *(spec.actuator(name) for name in names)):
        spec.delete(part)


def _add_servos(spec: mujoco.MjSpec, joint: str, drive: Drive) -> None:
    """Add the spring, damper and actuators of a joint's drive; the class `ForceLimits` limits their force while stepping."""
    for servo, gain in servos(joint, drive):
        if gain > 0:
            _add_actuator(spec, servo, joint, gain)
    driven = spec.joint(joint)
    _add_spring(driven, drive.stiffness, 0.0)
    driven.damping[0] += drive.damping
    driven.actfrclimited = False


def _add_actuator(spec: mujoco.MjSpec, name: str, joint: str, gain: float) -> None:
    """Add an actuator with force = gain * control, independent of the model's default classes."""
    plain = mujoco.MjSpec().default
    spec.add_actuator(default=plain, name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT).gainprm[0] = gain


def _add_spring(joint: mujoco.MjsJoint, stiffness: float, rest: float) -> None:
    """Add a spring to a joint; it is combined with springs that the joint already has."""
    total = joint.stiffness[0] + stiffness
    if total > 0:
        joint.springref = (joint.stiffness[0] * joint.springref + stiffness * rest) / total
    joint.stiffness[0] = total


def _tie(spec: mujoco.MjSpec, joint: str, mimic: Mimic) -> None:
    """Add the constraint of a mimic joint: its position is offset + multiplier * position of the leader.

    Both joints are at position zero in `qpos0`.
    """
    equality = spec.add_equality(name=f"{joint}.mimic", type=mujoco.mjtEq.mjEQ_JOINT)
    equality.name1, equality.name2 = joint, mimic.leader
    equality.data[:5] = mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0
    equality.solref, equality.solimp[:2] = TIGHT_SOLREF, TIGHT_SOLIMP


def _hollow_meshes(spec: mujoco.MjSpec) -> None:
    """Set the inertia of meshes to `shell`, because MuJoCo rejects flat meshes without volume.

    Meshes of colliders from which MuJoCo computes the mass of a body stay solid.
    """
    weighed = (body for body in spec.bodies if not body.explicitinertial)
    solid = {geom.meshname for body in weighed for geom in _colliders(body)}
    for mesh in spec.meshes:
        if mesh.name not in solid:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL


def _colliders(body: mujoco.MjsBody) -> list[mujoco.MjsGeom]:
    return [geom for geom in body.geoms if geom.contype or geom.conaffinity]


def _shape_wheels(spec: mujoco.MjSpec, robot: RobotInstance) -> None:
    """Replace the colliders of wheels in `wheel_colliders` of the robot file.

    Ellipsoids touch the floor at one point; cylinders would rub alternately on both rims.
    """
    for link, shape in robot.spec.wheel_colliders.items():
        if spec.body(link) is None:  # a site of a MuJoCo model; already reported
            continue
        if isinstance(shape, WheelColliderSpec):
            _replace_colliders(spec, link, shape, robot.description)
        elif shape == "ellipsoid":
            for geom in _colliders(spec.body(link)):
                radius, half_width = geom.size[0], geom.size[1]
                geom.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
                geom.size = [radius, radius, half_width]


def _replace_colliders(spec: mujoco.MjSpec, link: str, shape: WheelColliderSpec, description: RobotDescription) -> None:
    """Replace all colliders of a wheel by one about the axis of its joint, with the colour of the first replaced collider."""
    body, carrier = spec.body(link), description.links[link].carrier
    if carrier is None:  # already reported
        return
    old = _colliders(body)
    ellipsoid, half = shape.shape == "ellipsoid", shape.width / 2
    size = [shape.radius, shape.radius, half] if ellipsoid else [shape.radius, half, 0.0]
    kind = mujoco.mjtGeom.mjGEOM_ELLIPSOID if ellipsoid else mujoco.mjtGeom.mjGEOM_CYLINDER
    turn = np.zeros(4)
    mujoco.mju_quatZ2Vec(turn, np.array(carrier.axis))
    position = np.array(carrier.axis) * shape.offset
    made = body.add_geom(name=f"{link}.wheel", type=kind, size=size, pos=position, quat=turn)
    if old:
        made.rgba, made.material = old[0].rgba, old[0].material
    for geom in old:
        spec.delete(geom)


def _group_geoms(spec: mujoco.MjSpec, robot: RobotInstance) -> None:
    """Set geom groups so that colliders are drawn only on links without visuals."""
    for link in robot.description.links:
        geoms, solid = list(spec.body(link).geoms), _colliders(spec.body(link))
        for geom in geoms:
            geom.group = PICTURES
        for geom in solid:
            geom.group = RAYS if len(solid) < len(geoms) else RAYS_AND_PICTURES


def _apply_materials(spec: mujoco.MjSpec, robot: RobotInstance, floor: float, findings: Findings) -> None:
    for name, material in robot.spec.materials.items():
        for link in material.bind:
            contact = against_floor(material, floor, wheel=link in robot.spec.wheel_colliders)
            for geom in _colliders(spec.body(link)):
                contact.tell(geom)
        if material.bind and (told := sentences(name, material, floor)):
            findings.add("N103", told[0], robot.file.key_span("materials", name), *told[1:])


def _memory_of_exclusions(robot: RobotInstance) -> float:
    return PAIR * sum(1 for _ in itertools.islice(_excluded_pairs(robot), MAX_MEMORY // PAIR + 1))


def _excluded_pairs(robot: RobotInstance) -> Iterator[tuple[str, str]]:
    """Yield the names of each two links between which contacts are excluded, in order of the links.

    Contacts between colliders of one robot are excluded, as Isaac's importer does, because they often overlap. With
    `self_collision`, links connected by a joint still do not collide, as in PhysX. MuJoCo excludes these pairs itself, except for
    joints on a fixed base. Colliders of a link named `world` collide with all others.
    """
    links, top = robot.description.links, _rigid(robot.description)
    solid = [link.name for link in links.values() if link.colliders and link.name != WORLD]
    fixed = robot.disabled.free_link is None
    base = {name for name in links if fixed and top[name] == robot.description.root}
    on_base = {name for name in links if (joint := links[top[name]].carrier) is not None and joint.parent in base}
    if not robot.spec.self_collision:
        yield from itertools.combinations(solid, 2)
        return
    number = {name: index for index, name in enumerate(solid)}
    for name in solid:
        partners = on_base if name in base else base if name in on_base else set()
        later = sorted(number[other] for other in partners if number.get(other, -1) > number[name])
        yield from ((name, solid[index]) for index in later)


def _rigid(description: RobotDescription) -> dict[str, str]:
    """Return a dict from the name of each link to the name of the topmost link to which it is rigidly connected."""
    top: dict[str, str] = {}
    for link in description.depth_first():
        fixed = link.carrier is not None and not link.carrier.moves
        top[link.name] = top[link.carrier.parent] if link.carrier is not None and fixed else link.name
    return top


def _keep_awake(spec: mujoco.MjSpec) -> None:
    """Exclude robots from MuJoCo's sleep, because sensors of a sleeping robot measure no contacts and forces."""
    trees = list(spec.worldbody.bodies)
    while trees:
        body = trees.pop()
        if list(body.joints):
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
        else:
            trees += body.bodies


def _prune(spec: mujoco.MjSpec, robot: RobotInstance) -> None:
    """Delete links that have no mass, geoms, joints or child bodies."""
    for link in reversed(list(robot.description.depth_first())):
        body = spec.body(link.name)
        if link.carrier is not None and not (link.mass or list(body.geoms) or list(body.joints) or list(body.bodies)):
            spec.delete(body)
