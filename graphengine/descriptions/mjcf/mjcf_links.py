"""Describes the links, joints, shapes and frames of a compiled MuJoCo model as URDF; physics uses the model itself.

A body with several joints, or with a joint away from its origin, becomes a chain of links. Sites and cameras become links
without mass and shapes, on which robot files can mount sensors. Ball and free joints below the root become floating joints.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from graphengine.descriptions.actuators.mjcf_actuators import strongest
from graphengine.descriptions.engine import collides, mujoco
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.urdf.urdf import WORLD
from graphengine.devices.rotation import (
    IDENTITY,
    NOWHERE,
    ORIGIN,
    Pose,
    Quaternion,
    Vector3,
    compose,
    pose_of,
    relative,
)
from graphengine.format.diagnostics import Span

_JOINT, _GEOM = mujoco.mjtJoint, mujoco.mjtGeom
FLOATING = (_JOINT.mjJNT_FREE.value, _JOINT.mjJNT_BALL.value)
VISIBLE = 2
"""Highest group of geoms that MuJoCo's viewers show by default."""


class MjcfLinks:
    """Converts the compiled MuJoCo model of one robot to a URDF description.

    Args:
        model: compiled model that contains only the robot; all its bodies and joints have names.
        meshes: URI of the file, and scale, by mesh name.
        places: source locations of bodies, joints, sites and cameras, by name.
        span: source location of the model, for everything that is not in `places`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        meshes: Mapping[str, tuple[str, Vector3]],
        places: Mapping[str, Span],
        span: Span,
    ) -> None:
        self.model = model
        self.meshes = meshes
        self.places = places
        self.span = span
        self.poses: dict[str, Pose] = {}
        """Pose of each joint in its parent link's frame by name, without the rounding of the angles in URDF."""
        self.floating: list[str] = []
        """Names of the ball and free joints below the root; the description writes them as fixed joints."""
        tops = [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
        alone = len(tops) == 1 and not (model.geom_bodyid == 0).any() and self._moves_freely_or_not_at_all(tops[0])
        self.root = model.body(tops[0]).name if alone else WORLD
        self.free = alone and model.body_jntnum[tops[0]] == 1
        """Whether the root link has a free joint."""
        self._links = {model.body(index).name for index in range(model.nbody)}
        self._joints = {model.joint(index).name for index in range(model.njnt)}
        self._strongest = strongest(model)
        self._solid = collides(model)
        self._children: list[Element] = []

    def _moves_freely_or_not_at_all(self, body: int) -> bool:
        count, first = self.model.body_jntnum[body], self.model.body_jntadr[body]
        return bool(count == 0 or (count == 1 and self.model.jnt_type[first] == _JOINT.mjJNT_FREE))

    def element(self, name: str) -> Element:
        """Return the `robot` element of the description; call this once. `name` is the name of the robot."""
        model = self.model
        root = Element("robot", {"name": name}, self.span)
        for body in range(model.nbody):
            link = model.body(body).name
            if body > 0 or self.root == WORLD:
                self._children.append(self._link(link, body))
            if body > 0 and link != self.root:
                self._fasten(body)
        for site in range(model.nsite):
            pose = pose_of(model.site_pos[site], model.site_quat[site])
            self._frame(model.site(site).name, "site", int(model.site_bodyid[site]), pose)
        for camera in range(model.ncam):
            pose = pose_of(model.cam_pos[camera], model.cam_quat[camera])
            self._frame(model.camera(camera).name, "camera", int(model.cam_bodyid[camera]), pose)
        followers: dict[str, str] = {}
        for equality in range(model.neq):
            self._mimic(equality, followers)
        root.children = self._children
        return root

    # Links

    def _link(self, name: str, body: int) -> Element:
        model, span = self.model, self.places.get(name, self.span)
        link = Element("link", {"name": name}, span)
        if model.body_mass[body] > 0:
            link.children.append(self._inertial(body, span))
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            tags = ["collision"] if self._solid[geom] else []
            tags += ["visual"] if model.geom_group[geom] <= VISIBLE else []
            for tag in tags:
                shape, pose = self._shape(geom, span)
                geometry = Element("geometry", {}, span, [shape])
                link.children.append(Element(tag, {}, span, [_origin(pose, span), geometry]))
        return link

    def _inertial(self, body: int, span: Span) -> Element:
        model = self.model
        terms = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "0")
        terms |= dict(zip(("ixx", "iyy", "izz"), map(repr, model.body_inertia[body].tolist()), strict=True))
        mass = Element("mass", {"value": repr(float(model.body_mass[body]))}, span)
        origin = _origin(pose_of(model.body_ipos[body], model.body_iquat[body]), span)
        return Element("inertial", {}, span, [origin, mass, Element("inertia", terms, span)])

    def _shape(self, geom: int, span: Span) -> tuple[Element, Pose]:
        """Return the URDF shape of a geom and its pose in the link's frame.

        URDF has no ellipsoids, planes or height fields: a cylinder or a bounding box replaces them.
        """
        model = self.model
        kind, size = model.geom_type[geom], model.geom_size[geom].tolist()
        pose = pose_of(model.geom_pos[geom], model.geom_quat[geom])
        if kind == _GEOM.mjGEOM_SPHERE:
            return Element("sphere", {"radius": repr(size[0])}, span), pose
        if kind == _GEOM.mjGEOM_CYLINDER or kind == _GEOM.mjGEOM_CAPSULE:
            tag = "cylinder" if kind == _GEOM.mjGEOM_CYLINDER else "capsule"
            return Element(tag, {"radius": repr(size[0]), "length": repr(2 * size[1])}, span), pose
        if kind == _GEOM.mjGEOM_ELLIPSOID and size[0] == size[1]:  # a wheel
            return Element("cylinder", {"radius": repr(size[0]), "length": repr(2 * size[2])}, span), pose
        if kind == _GEOM.mjGEOM_BOX or kind == _GEOM.mjGEOM_ELLIPSOID:
            return Element("box", {"size": _numbers([2 * side for side in size])}, span), pose
        mesh = int(model.geom_dataid[geom])
        if kind == _GEOM.mjGEOM_MESH and (file := self.meshes.get(model.mesh(mesh).name)) is not None:
            reference, scale = file
            moved = pose_of(model.mesh_pos[mesh], model.mesh_quat[mesh])  # MuJoCo centres meshes
            attributes = {"filename": reference, "scale": _numbers(scale)}
            return Element("mesh", attributes, span), compose(pose, relative(moved, NOWHERE))
        centre, half = model.geom_aabb[geom].reshape(2, 3).tolist()
        return Element("box", {"size": _numbers([2 * side for side in half])}, span), compose(
            pose, ((centre[0], centre[1], centre[2]), IDENTITY)
        )

    def _frame(self, name: str, kind: str, body: int, pose: Pose) -> None:
        """Add a link without mass and shapes, and a fixed joint, for a site or camera that has a name."""
        if not name or (body == 0 and self.root != WORLD):
            return
        link = self._unused(name if name not in self._links else f"{name}_{kind}", self._links)
        self._children.append(Element("link", {"name": link}, self.places.get(name, self.span)))
        self._join(self._unused(f"{link}_joint", self._joints), "fixed", self.model.body(body).name, link, pose)

    # Joints

    def _fasten(self, body: int) -> None:
        """Connect the link of a body to its parent: by a chain of its joints with empty links between, or by a fixed joint."""
        model, name = self.model, self.model.body(body).name
        above = model.body(int(model.body_parentid[body])).name
        pose = pose_of(model.body_pos[body], model.body_quat[body])
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for joint in range(first, first + count):
            jointed, last = model.joint(joint).name, joint == first + count - 1
            if model.jnt_type[joint] in FLOATING:
                self.floating.append(jointed)
                self._join(jointed, "fixed", above, name, pose)
                return
            anchor = model.jnt_pos[joint].tolist()
            below = name if last and not any(anchor) else self._unused(f"{jointed}_frame", self._links)
            origin = compose(compose(pose, ((anchor[0], anchor[1], anchor[2]), IDENTITY)), self._reference(joint))
            if below != name:
                self._children.append(Element("link", {"name": below}, self.places.get(jointed, self.span)))
            self._join(jointed, self._type(joint), above, below, origin, joint)
            above, pose = below, ((-anchor[0], -anchor[1], -anchor[2]), IDENTITY)
        if above != name:
            self._join(self._unused(f"{name}_joint", self._joints), "fixed", above, name, pose)

    def _type(self, joint: int) -> str:
        if self.model.jnt_type[joint] == _JOINT.mjJNT_SLIDE:
            return "prismatic"
        return "revolute" if self.model.jnt_limited[joint] else "continuous"

    def _reference(self, joint: int) -> Pose:
        """Return the transform that moves a joint from its reference position (`qpos0`) to position zero."""
        model, axis = self.model, self.model.jnt_axis[joint].tolist()
        back = -float(model.qpos0[model.jnt_qposadr[joint]])
        if model.jnt_type[joint] == _JOINT.mjJNT_SLIDE:
            return (axis[0] * back, axis[1] * back, axis[2] * back), IDENTITY
        sine, cosine = math.sin(back / 2), math.cos(back / 2)
        return ORIGIN, (axis[0] * sine, axis[1] * sine, axis[2] * sine, cosine)

    def _join(self, name: str, kind: str, parent: str, child: str, pose: Pose, joint: int = -1) -> None:
        """Add a joint element; `joint` is the joint's index in the model, -1 for a joint that exists only in the description."""
        model, span = self.model, self.places.get(name, self.span)
        ends = [Element("parent", {"link": parent}, span), Element("child", {"link": child}, span)]
        element = Element("joint", {"name": name, "type": kind}, span, [_origin(pose, span), *ends])
        self.poses[name] = pose
        if joint >= 0:
            effort = self._strongest.get(name, 0.0)
            lower, upper = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (0.0, 0.0)
            limit = {"lower": repr(lower), "upper": repr(upper), "effort": repr(effort), "velocity": "0.0"}
            dof = model.jnt_dofadr[joint]
            losses = {
                "damping": repr(float(model.dof_damping[dof])),
                "friction": repr(float(model.dof_frictionloss[dof])),
            }
            element.children += [
                Element("axis", {"xyz": _numbers(model.jnt_axis[joint].tolist())}, span),
                Element("limit", limit, span),
                Element("dynamics", losses, span),
            ]
        self._children.append(element)

    def _mimic(self, equality: int, followers: dict[str, str]) -> None:
        """Write an equality constraint between two joints as a mimic joint, if it is active and linear.

        `followers` maps each mimic joint so far to its leader; a constraint that would close a cycle is ignored.
        """
        model = self.model
        if model.eq_type[equality] != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[equality]:
            return
        one, other = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        offset, multiplier, *bends = model.eq_data[equality, :5].tolist()
        if other < 0 or any(bends) or model.jnt_type[one] in FLOATING or model.jnt_type[other] in FLOATING:
            return
        follower, leader, above = model.joint(one).name, model.joint(other).name, model.joint(other).name
        while above in followers:
            above = followers[above]
        if above == follower or follower in followers:
            return
        followers[follower] = leader
        start, begin = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (one, other))
        law = {"joint": leader, "multiplier": repr(multiplier), "offset": repr(start + offset - multiplier * begin)}
        joints = (element for element in self._children if element.tag == "joint" and element.get("name") == follower)
        for element in joints:
            element.children.append(Element("mimic", law, element.span))

    def _unused(self, name: str, taken: set[str]) -> str:
        while name in taken:
            name += "_"
        taken.add(name)
        return name


def _origin(pose: Pose, span: Span) -> Element:
    position, orientation = pose
    return Element("origin", {"xyz": _numbers(position), "rpy": _numbers(_rpy(orientation))}, span)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _rpy(orientation: Quaternion) -> Vector3:
    """Return the roll, pitch and yaw angles of URDF (about the fixed x, y and z axes, rad) of a quaternion."""
    x, y, z, w = orientation
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    if abs(sine) > 1.0 - 1e-12:  # looking straight up or down: roll and yaw turn about the same axis
        return 0.0, math.copysign(math.pi / 2, sine), -2.0 * math.copysign(1.0, sine) * math.atan2(x, w)
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(sine), math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
