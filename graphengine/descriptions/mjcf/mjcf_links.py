"""Describes the links, joints, shapes and frames of a compiled MuJoCo model; physics uses the model itself.

A body with several joints, or with a joint away from its origin, becomes a chain of links. Sites and cameras become links
without mass and shapes, on which robot files can mount sensors. Ball and free joints below the root become floating joints.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from graphengine.descriptions.actuators.mjcf_actuators import strongest
from graphengine.descriptions.engine import collides, mujoco
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.robot_description import WORLD, Bounds, Inertial, Joint, Link, Mimic
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from graphengine.devices.rotation import IDENTITY, NOWHERE, ORIGIN, Pose, Vector3, compose, pose_of, relative, vector
from graphengine.format.diagnostics import Span

_JOINT, _GEOM = mujoco.mjtJoint, mujoco.mjtGeom
FLOATING = (_JOINT.mjJNT_FREE.value, _JOINT.mjJNT_BALL.value)
VISIBLE = 2
"""Highest group of geoms that MuJoCo's viewers show by default."""


class MjcfLinks:
    """Converts the compiled MuJoCo model of one robot to links and joints.

    Args:
        model: compiled model that contains only the robot; all its bodies and joints have names.
        meshes: a dict from names of meshes to the URI of the file and the scale.
        places: a dict from names to source locations of bodies, joints, sites and cameras.
        span: source location of the model, for all parts of it that are not in `places`.
    """

    def __init__(
        self, model: mujoco.MjModel, meshes: Mapping[str, tuple[str, Vector3]], places: Mapping[str, Span], span: Span
    ) -> None:
        self.model = model
        self.meshes = meshes
        self.places = places
        self.span = span
        self.links: dict[str, Link] = {}
        self.joints: dict[str, Joint] = {}
        tops = [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
        alone = len(tops) == 1 and not (model.geom_bodyid == 0).any() and self._moves_freely_or_not_at_all(tops[0])
        self.root = model.body(tops[0]).name if alone else WORLD
        self.free = alone and model.body_jntnum[tops[0]] == 1
        """Whether the root link has a free joint."""
        self._names = {model.body(index).name for index in range(model.nbody)}
        self._joint_names = {model.joint(index).name for index in range(model.njnt)}
        self._strongest = strongest(model)
        self._solid = collides(model)
        for body in range(model.nbody):
            link = model.body(body).name
            if body > 0 or self.root == WORLD:
                self._add_link(link, link, self._inertial(body), self._shapes(link, body))
            if body > 0 and link != self.root:
                self._fasten(body)
        for kind, get, count in (("site", model.site, model.nsite), ("camera", model.camera, model.ncam)):
            for frame in map(get, range(count)):
                self._frame(frame.name, kind, int(frame.bodyid[0]), pose_of(frame.pos, frame.quat))
        for equality in range(model.neq):
            self._mimic(equality)

    def _moves_freely_or_not_at_all(self, body: int) -> bool:
        count, first = self.model.body_jntnum[body], self.model.body_jntadr[body]
        return bool(count == 0 or (count == 1 and self.model.jnt_type[first] == _JOINT.mjJNT_FREE))

    # Links

    def _add_link(self, name: str, place: str, inertial: Inertial | None = None, shapes: Sequence[Shape] = ()) -> None:
        """Add a link; `place` is the name of the body, joint, site or camera from which the link is made."""
        span = self.places.get(place, self.span)
        self.links[name] = Link(name, Element("link", {"name": name}, span), inertial, shapes)

    def _inertial(self, body: int) -> Inertial | None:
        model = self.model
        if not model.body_mass[body] > 0:
            return None
        xx, yy, zz = model.body_inertia[body].tolist()
        pose = pose_of(model.body_ipos[body], model.body_iquat[body])
        return Inertial(float(model.body_mass[body]), (xx, yy, zz, 0.0, 0.0, 0.0), pose)

    def _shapes(self, link: str, body: int) -> list[Shape]:
        model, span = self.model, self.places.get(link, self.span)
        found: list[Shape] = []
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            tags = ["collision"] if self._solid[geom] else []
            tags += ["visual"] if model.geom_group[geom] <= VISIBLE else []
            for tag in tags:
                geometry, pose = self._shape(geom, span)
                name = f"{link}.{len(found)}"
                found.append(Shape(name, tag == "visual", geometry, pose, None, Element(tag, {}, span), span))
        return found

    def _shape(self, geom: int, span: Span) -> tuple[Geometry, Pose]:
        """Return the geometry of a geom and its pose in the link's frame.

        URDF has no ellipsoids, planes or height fields: a cylinder or a bounding box replaces them.
        """
        model = self.model
        kind, size = model.geom_type[geom], model.geom_size[geom].tolist()
        pose = pose_of(model.geom_pos[geom], model.geom_quat[geom])
        if kind == _GEOM.mjGEOM_SPHERE:
            return Sphere(size[0]), pose
        if kind == _GEOM.mjGEOM_CYLINDER or kind == _GEOM.mjGEOM_CAPSULE:
            return (Cylinder if kind == _GEOM.mjGEOM_CYLINDER else Capsule)(size[0], 2 * size[1]), pose
        if kind == _GEOM.mjGEOM_ELLIPSOID and size[0] == size[1]:  # a wheel
            return Cylinder(size[0], 2 * size[2]), pose
        if kind == _GEOM.mjGEOM_BOX or kind == _GEOM.mjGEOM_ELLIPSOID:
            return Box(vector(2 * model.geom_size[geom])), pose
        mesh = int(model.geom_dataid[geom])
        if kind == _GEOM.mjGEOM_MESH and (file := self.meshes.get(model.mesh(mesh).name)) is not None:
            reference, scale = file
            moved = pose_of(model.mesh_pos[mesh], model.mesh_quat[mesh])  # MuJoCo centres meshes
            element = Element("mesh", {"filename": reference}, span)
            return Mesh(reference, scale, element), compose(pose, relative(moved, NOWHERE))
        centre, half = model.geom_aabb[geom].reshape(2, 3)
        return Box(vector(2 * half)), compose(pose, (vector(centre), IDENTITY))

    def _frame(self, name: str, kind: str, body: int, pose: Pose) -> None:
        """Add a link without mass and shapes, and a fixed joint, for a site or camera that has a name."""
        if not name or (body == 0 and self.root != WORLD):
            return
        link = self._unused(name if name not in self._names else f"{name}_{kind}", self._names)
        self._add_link(link, name)
        self._join(self._unused(f"{link}_joint", self._joint_names), "fixed", self.model.body(body).name, link, pose)

    # Joints

    def _fasten(self, body: int) -> None:
        """Connect the link of a body to its parent by the body's joints, with empty links between them, or by a fixed joint."""
        model, name = self.model, self.model.body(body).name
        above = model.body(int(model.body_parentid[body])).name
        pose = pose_of(model.body_pos[body], model.body_quat[body])
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for joint in range(first, first + count):
            jointed, last = model.joint(joint).name, joint == first + count - 1
            if model.jnt_type[joint] in FLOATING:
                self._join(jointed, "floating", above, name, pose)
                return
            anchor = vector(model.jnt_pos[joint])
            below = name if last and not any(anchor) else self._unused(f"{jointed}_frame", self._names)
            origin = compose(compose(pose, (anchor, IDENTITY)), self._reference(joint))
            if below != name:
                self._add_link(below, jointed)
            self._join(jointed, self._type(joint), above, below, origin, joint)
            above, pose = below, ((-anchor[0], -anchor[1], -anchor[2]), IDENTITY)
        if above != name:
            self._join(self._unused(f"{name}_joint", self._joint_names), "fixed", above, name, pose)

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
        """Add a joint; `joint` is the joint's index in the model, -1 for a joint that exists only in the description."""
        model, element = self.model, Element("joint", {"name": name, "type": kind}, self.places.get(name, self.span))
        made = Joint(name, kind, parent, child, pose, element)
        if joint >= 0:
            lower, upper = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (0.0, 0.0)
            dof = model.jnt_dofadr[joint]
            made.stated_axis = vector(model.jnt_axis[joint])
            made.bounds = Bounds(lower, upper, self._strongest.get(name, 0.0), 0.0, element)
            made.losses = float(model.dof_damping[dof]), float(model.dof_frictionloss[dof])
        self.joints[name] = made
        self.links[parent].below.append(made)
        self.links[child].carrier = made

    def _mimic(self, equality: int) -> None:
        """Make a joint mimic another if an equality constraint is active and linear, and closes no cycle of mimic joints."""
        model = self.model
        if model.eq_type[equality] != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[equality]:
            return
        one, other = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        offset, multiplier, *bends = model.eq_data[equality, :5].tolist()
        if other < 0 or any(bends) or model.jnt_type[one] in FLOATING or model.jnt_type[other] in FLOATING:
            return
        follower, leader = self.joints[model.joint(one).name], self.joints[model.joint(other).name]
        above = leader
        while above.mimic is not None:
            above = self.joints[above.mimic.leader]
        if above is follower or follower.mimic is not None:
            return
        start, begin = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (one, other))
        follower.mimic = Mimic(leader.name, multiplier, start + offset - multiplier * begin, follower.element)

    def _unused(self, name: str, taken: set[str]) -> str:
        while name in taken:
            name += "_"
        taken.add(name)
        return name
