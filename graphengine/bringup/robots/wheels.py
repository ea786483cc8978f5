"""Finds the wheels of a robot, replaces colliders that do not roll smoothly, and gives wheels a material with full grip."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from graphengine.bringup.robots.trial import trial
from graphengine.descriptions.engine import Floats, body_names, collides, mujoco
from graphengine.descriptions.geoms import extents, mesh_vertices
from graphengine.descriptions.robot_description import TURNING, Joint
from graphengine.descriptions.robot_files.draft import ALIGNED, Draft, Remark, RobotWheel, rounded
from graphengine.descriptions.robot_files.entries import Entry, WheelKeys, material
from graphengine.descriptions.rollers import NO_ROLLERS, rollers_of
from graphengine.descriptions.shapes import Cylinder, kind_of
from graphengine.devices.rotation import Vector3, rotate
from graphengine.format.wording import printable

WIDE = 8 * math.pi
"""Range above which a revolute joint counts as continuous, rad: four turns."""
ROUND = 0.93
"""Minimum ratio of the smallest to the largest radius of a wheel, which a regular polygon with ten corners exceeds."""
ROLLING = 0.8
"""Minimum ratio of the smallest to the largest reach of a wheel with rollers."""
EQUAL = 0.005
"""Maximum relative difference of the radii of meshes of equal wheels."""
LEVEL = 0.3
"""Maximum cosine of the angle between the axis of a wheel on the floor and the vertical."""
STANDING = 0.02
"""Maximum height (m) of the lowest point of a link on the floor above the lowest collider."""
PLUMB = 0.9
"""Minimum cosine of the angle between the axis of a caster's swivel and the vertical."""
_DIRECTIONS = np.linspace(0.0, 2 * math.pi, 72, endpoint=False)
_TURNS = ([0, 1, 2], [2, 0, 1], [1, 2, 0])
"""Permutations of coordinates that turn a circle about z into circles about the three axes."""
MATERIAL = "WheelMaterial"
_FULL_GRIP = 1.0


def find_wheels(draft: Draft) -> None:
    """Find the wheels, and add `wheel_colliders` entries for wheels whose colliders do not roll smoothly."""
    if (model := trial(draft)) is None:
        return
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    solid = np.flatnonzero(collides(model))
    below = extents(model, data, solid)
    if below is None:
        return
    lowest = float(below[0][2])
    geoms = defaultdict[int, list[int]](list)
    for geom in solid.tolist():
        geoms[int(model.geom_bodyid[geom])].append(geom)
    for body, colliders in geoms.items():
        if (reach := extents(model, data, colliders)) is not None and reach[0][2] < lowest + STANDING:
            draft.standing[model.body(body).name] = float(reach[0][2] - data.body(draft.description.root).xpos[2])
    axes = draft.description.axes_in_root()
    swivelling, rollers = _swivelling(draft, axes), rollers_of(draft.description)
    rolling = {name for each in rollers.values() for name in each.joints}
    known = set(body_names(model))
    for joint in filter(turns_on, draft.description.moving()):
        if joint.child not in known or joint.name in rolling:  # a frame between two joints of one body
            continue
        own = rollers.get(joint.name, NO_ROLLERS)
        colliders = [geom for link in (joint.child, *own.links) for geom in geoms[model.body(link).id]]
        wheel = _wheel(draft, joint, axes[joint.name], model, data, colliders, lowest, rollers=bool(own.links))
        if wheel is not None:
            draft.wheels[joint.name] = replace(wheel, swivels=joint.name in swivelling, rollers=own)
    _equalize(draft)
    for wheel in draft.wheels.values():
        _shape(draft, wheel)


def _equalize(draft: Draft) -> None:
    """Give mesh wheels on the floor with nearly equal radii their mean radius, because all of them should carry the robot."""
    wheels = draft.wheels.values()
    meshes = [each for each in wheels if each.on_floor and each.collider == "mesh" and not each.rollers.links]
    for wheel in meshes:
        alike = [each.radius for each in meshes if abs(each.radius - wheel.radius) < EQUAL * wheel.radius]
        draft.wheels[wheel.joint] = replace(wheel, radius=sum(alike) / len(alike))


def turns_on(joint: Joint) -> bool:
    """Return whether a joint rotates without limits, or within a range larger than `WIDE`."""
    limits = joint.limits
    return joint.type in TURNING and (limits is None or limits[1] - limits[0] > WIDE)


def _wheel(
    draft: Draft,
    joint: Joint,
    axis: Vector3,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    geoms: list[int],
    lowest: float,
    *,
    rollers: bool,
) -> RobotWheel | None:
    """Return the wheel that a joint turns; None if the colliders of the child link are not round about the joint's axis.

    Args:
        draft: receives a remark if a cylinder on the floor does not turn about its own axis.
        joint: joint that may turn a wheel.
        axis: axis of the joint in the root link's frame.
        model: compiled model of the robot.
        data: state of the model with all joints at position zero.
        geoms: indices of the colliders of the child link.
        lowest: height of the lowest point of the robot, m.
        rollers: whether `geoms` contains the colliders of rollers on the wheel.
    """
    body = model.body(joint.child).id
    if not rollers and (crooked := _crooked(draft, joint)) is not None:
        reach = extents(model, data, geoms)
        if reach is not None and reach[0][2] < lowest + STANDING:
            draft.noticed.append(crooked)
        return None
    points = [_surface(model, data, geom) for geom in geoms]
    root = data.body(draft.description.root)
    axle, joint_at = root.xmat.reshape(3, 3) @ np.array(axis), data.xpos[body]
    if not points or (size := _size(np.concatenate(points) - joint_at, axle, rollers=rollers)) is None:
        return None
    radius, width, offset = size
    centre = joint_at + axle * offset
    on_floor = bool(centre[2] - radius < lowest + 0.25 * radius + 0.002 and abs(axle[2]) < LEVEL)
    kinds = {kind_of(collider.geometry) for collider in draft.description.links[joint.child].colliders}
    tag = kinds.pop() if len(kinds) == 1 else "mesh"
    if not on_floor and not rollers and (tag not in ("cylinder", "sphere") or joint.type != "continuous"):
        return None  # a roll of an arm, a lidar that spins
    in_root = root.xmat.reshape(3, 3).T @ (centre - root.xpos)
    place = (float(in_root[0]), float(in_root[1]), float(in_root[2]))
    return RobotWheel(joint.name, joint.child, radius, width, offset, axis, place, tag, on_floor)


def _surface(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Floats:
    """Return points on the surface of a geom in world coordinates, m, shape (number of points, 3).

    The points are the vertices of a mesh, the corners of a box, or circles on other shapes.
    """
    kind, size = model.geom_type[geom], model.geom_size[geom]
    ends = [[0, 0, -size[1]], [0, 0, size[1]]]
    circle = np.stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS), np.zeros_like(_DIRECTIONS)], axis=1)
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        points = mesh_vertices(model, int(model.geom_dataid[geom]))
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        points = np.concatenate([circle * size[0] + end for end in ends])
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        points = np.concatenate([circle[:, turn] * size[0] + end for turn in _TURNS for end in ends])
    elif kind == mujoco.mjtGeom.mjGEOM_BOX:
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    else:
        radii = np.where(size > 0, size, size[0])
        points = np.concatenate([circle[:, turn] * radii for turn in _TURNS])
    placed: Floats = data.geom_xpos[geom] + points @ data.geom_xmat[geom].reshape(3, 3).T
    return placed


def _size(points: Floats, axle: Floats, *, rollers: bool) -> tuple[float, float, float] | None:
    """Return radius, width and offset along the axle (m) of points that form a wheel about an axle through the origin.

    The radius of a wheel with rollers is the mean reach of the convex hull on which it rolls: the perimeter divided by 2 pi.
    Return None if the points are not round about the axle, or if the width exceeds four times the radius, as in a roller.
    """
    along = points @ axle
    across = np.cross(axle, [1.0, 0.0, 0.0] if abs(axle[0]) < 0.9 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    u, v = points @ across, points @ np.cross(axle, across)
    reach = np.array([np.max(u * math.cos(angle) + v * math.sin(angle)) for angle in _DIRECTIONS])
    radius, width = float(reach.max()), float(np.ptp(along))
    if radius <= 0 or reach.min() < (ROLLING if rollers else ROUND) * radius or width > 4 * radius:
        return None
    return float(reach.mean()) if rollers else radius, width, float(along.min() + along.max()) / 2


def _swivelling(draft: Draft, axes: Mapping[str, Vector3]) -> set[str]:
    """Return the names of swivelling joints: uncommanded vertical joints without limits, and uncommanded joints below these."""
    commanded, found = _commanded(draft), set[str]()
    for joint in (joint for link in draft.description.depth_first() for joint in link.below):
        above = draft.description.links[joint.parent].carrier
        hangs = above is not None and above.name in found
        if joint.name not in commanded and (hangs or (turns_on(joint) and abs(axes[joint.name][2]) > PLUMB)):
            found.add(joint.name)
    return found


def _commanded(draft: Draft) -> set[str]:
    """Return the names of joints in transmissions and ros2_control command interfaces, and all texts in Gazebo plugins."""
    found: set[str] = set()
    for owner in draft.description.element.children:
        if owner.tag == "transmission":
            found |= {joint.get("name") for joint in owner.all("joint")}
        elif owner.tag == "ros2_control":
            found |= {joint.get("name") for joint in owner.all("joint") if joint.all("command_interface")}
        elif owner.tag == "gazebo":
            for plugin in owner.all("plugin"):
                if "state" not in (plugin.get("filename") + plugin.get("name")).lower():
                    found |= {part.text for part in plugin.walk()}
    return found


def _shape(draft: Draft, wheel: RobotWheel) -> None:
    """Add an ellipsoid as the collider of a wheel on the floor, unless the wheel is a sphere.

    The corners of a mesh and the rims of a cylinder would not roll smoothly.
    """
    colliders = draft.description.links[wheel.link].colliders
    if not wheel.on_floor or wheel.collider == "sphere" or wheel.rollers.links:
        return
    why = "ellipsoids touch the floor at one point each; the rims of a cylinder would scrub in a turn"
    comments = [] if draft.wheel_colliders else [why]
    if wheel.collider == "cylinder" and len(colliders) == 1:
        draft.wheel_colliders[wheel.link] = Entry("ellipsoid", comments)
        return
    value: WheelKeys = {"shape": "ellipsoid", "radius": rounded(wheel.radius, 6), "width": rounded(wheel.width, 6)}
    if abs(wheel.offset) > 1e-4:
        value["offset"] = rounded(wheel.offset, 6)
    draft.wheel_colliders[wheel.link] = Entry(value, comments)
    text = f"wheel {wheel.link}: an ellipsoid of radius {wheel.radius:.4g} m rolls in place of its {wheel.collider}"
    draft.guess(text, colliders[0].span)


def _crooked(draft: Draft, joint: Joint) -> Remark | None:
    """Return a remark if a joint turns a cylinder about another axis than that of the cylinder; else None."""
    colliders = draft.description.links[joint.child].colliders
    if len(colliders) != 1 or not isinstance(colliders[0].geometry, Cylinder):
        return None
    own = rotate(colliders[0].pose[1], (0.0, 0.0, 1.0))
    cosine = abs(sum(a * b for a, b in zip(own, joint.axis, strict=True)))
    if cosine > ALIGNED:
        return None
    angle = math.degrees(math.acos(cosine))
    text = f"joint {joint.name} turns the cylinder of {joint.child} about an axis {angle:.0f} degrees off its own: no wheel"
    return Remark(text, colliders[0].span)


def add_wheel_material(draft: Draft) -> None:
    """Bind the wheel material to all wheels on the floor without a material, except wheels of casters and dragging wheels."""
    bound = draft.bound()
    wheels = [wheel for wheel in draft.wheels.values() if wheel.on_floor and not wheel.swivels and not wheel.drags]
    links = [link for wheel in wheels for link in wheel.rollers.links or (wheel.link,)]
    links = [link for link in dict.fromkeys(links) if link not in bound]
    if not links or MATERIAL in draft.materials:
        return
    comment = "full grip; `max` selects the larger of this friction and the floor's"
    draft.guess(f"friction of wheels: {_FULL_GRIP:g} on any floor: {', '.join(map(printable, links))}")
    draft.materials[MATERIAL] = Entry(material(_FULL_GRIP, "max", links), [comment])
