"""A checked robot as an MjSpec that a world can attach."""

from __future__ import annotations

import itertools

from graphengine.diagnostics import Findings
from graphengine.world.drives import Drive, position_servo, velocity_servo
from graphengine.world.engine import PICTURES, RAYS, RAYS_AND_PICTURES, mujoco
from graphengine.world.materials import Contact, against_floor, sentence
from graphengine.world.references import READABLE_MESHES, Library
from graphengine.world.robot import Robot
from graphengine.world.urdf import shape_of
from graphengine.world.xmlfile import Element, mujoco_says, place_of, write

_COMPILER = {"fusestatic": "false", "discardvisual": "false", "strippath": "true"}
"""Against MuJoCo's defaults for URDF, by which fixed links and visuals vanish."""
_PASSED_ON = ("balanceinertia", "boundmass", "boundinertia", "inertiafromgeom")
"""Settings of a description's own <mujoco><compiler> that MuJoCo is told of."""
_JOINT_PARTS = ("origin", "parent", "child", "axis", "limit", "dynamics")


def robot_spec(robot: Robot, library: Library, floor: float, findings: Findings) -> mujoco.MjSpec | None:
    """The robot as MuJoCo's editable model, None when something is wrong with it.

    Args:
        robot: checked against its description.
        library: reads the meshes.
        floor: friction of what the robot stands on.
        findings: takes what is wrong, and notes on what was resolved.
    """
    before = len(findings.errors)
    element = _for_mujoco(robot, library, findings)
    if len(findings.errors) > before:
        return None
    text, spans = write(element)
    try:
        spec = mujoco.MjSpec.from_string(text, assets=library.assets)
    except (ValueError, mujoco.FatalError) as error:
        message, _, line = mujoco_says(error)
        findings.add("S103", f"MuJoCo: {message}", place_of(spans, line))
        return None
    spec.body(robot.spec.base_link).add_freejoint(name="root")
    for name, joint in robot.spec.joints.items():
        if robot.urdf.joints[name].moves:
            spec.joint(name).armature = joint.armature
    for name, drive in robot.drives.items():
        _add_servos(spec, name, drive)
    _shape_wheels(spec, robot)
    _group_geoms(spec, robot)
    _apply_materials(spec, robot, floor, findings)
    # As Isaac's importer has it: colliders of one robot, which often overlap, do not collide with each other.
    solid = [link.name for link in robot.urdf.links.values() if link.colliders]
    for one, other in itertools.combinations(solid, 2):
        spec.add_exclude(bodyname1=one, bodyname2=other)
    _prune(spec, robot)
    return spec


def _for_mujoco(robot: Robot, library: Library, findings: Findings) -> Element:
    """A description with only what MuJoCo should read, and meshes by their keys."""
    urdf = robot.urdf
    compiler = Element("compiler", dict(_COMPILER), urdf.element.span)
    for settings in urdf.element.all("mujoco"):
        own = settings.first("compiler")
        compiler.attributes |= {key: own.get(key) for key in _PASSED_ON if own is not None and key in own.attributes}
    root = Element("robot", {"name": robot.name}, urdf.element.span)
    root.children.append(Element("mujoco", {}, urdf.element.span, [compiler]))
    root.children += [_copy(material, ("color",)) for material in urdf.element.all("material")]
    undrawn: list[Element] = []
    for link in urdf.links.values():
        copied = _copy(link.element, ("inertial", "collision", "visual"))
        for part in list(copied.children):
            shape = shape_of(part)
            if shape is None or shape.tag != "mesh":
                continue
            if part.tag == "visual" and not shape.get("filename").lower().endswith(READABLE_MESHES):
                undrawn.append(shape)
                copied.children.remove(part)
            else:
                library.mesh(shape, urdf.path.parent)
        root.children.append(copied)
    if undrawn:
        text = f"{len(undrawn)} visuals are not drawn: MuJoCo reads {', '.join(READABLE_MESHES)} meshes"
        findings.add("N103", text, undrawn[0].place("filename"))
    root.children += [_copy(joint.element, _JOINT_PARTS) for joint in urdf.joints.values()]
    return root


def _copy(element: Element, parts: tuple[str, ...] = ()) -> Element:
    """A copy, with only the named children where any are named; textures stay behind."""
    children = [child for child in element.children if child.tag != "texture" and (not parts or child.tag in parts)]
    return Element(element.tag, dict(element.attributes), element.span, [_copy(child) for child in children])


def _collides(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.contype or geom.conaffinity)


def _add_servos(spec: mujoco.MjSpec, joint: str, drive: Drive) -> None:
    transmission = {"target": joint, "trntype": mujoco.mjtTrn.mjTRN_JOINT}
    if drive.stiffness > 0:
        spec.add_actuator(name=position_servo(joint), **transmission).set_to_position(kp=drive.stiffness)
    if drive.damping > 0:
        spec.add_actuator(name=velocity_servo(joint), **transmission).set_to_velocity(kv=drive.damping)


def _shape_wheels(spec: mujoco.MjSpec, robot: Robot) -> None:
    """An ellipsoid touches the floor in one point; the two at the rims of a cylinder scrub in a turn."""
    for link, shape in robot.spec.wheel_colliders.items():
        for geom in spec.body(link).geoms:
            if shape == "ellipsoid" and _collides(geom):
                radius, half_width = geom.size[0], geom.size[1]
                geom.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
                geom.size = [radius, radius, half_width]


def _group_geoms(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Colliders are drawn only where a link has no visual."""
    for link in robot.urdf.links:
        geoms = list(spec.body(link).geoms)
        drawn = any(not _collides(geom) for geom in geoms)
        for geom in geoms:
            geom.group = PICTURES if not _collides(geom) else RAYS if drawn else RAYS_AND_PICTURES


def _apply_materials(spec: mujoco.MjSpec, robot: Robot, floor: float, findings: Findings) -> None:
    for name, material in robot.spec.materials.items():
        contact: Contact | None = None
        for link in material.bind:
            contact = against_floor(material, floor, wheel=link in robot.spec.wheel_colliders)
            for geom in spec.body(link).geoms:
                if _collides(geom):
                    geom.friction[0] = contact.friction
                    geom.condim = contact.condim
                    geom.priority = contact.priority
                    geom.solref = contact.solref
        if contact is not None:
            findings.add("N103", sentence(name, material, floor, contact), robot.file.key_span("materials", name))


def _prune(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Delete links that are frames only: nothing to simulate, and their poses are those of what carries them."""
    for link in reversed(list(robot.urdf.depth_first())):
        body = spec.body(link.name)
        if link.carrier is not None and not (link.mass or list(body.geoms) or list(body.joints) or list(body.bodies)):
            spec.delete(body)
