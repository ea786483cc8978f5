"""The robots and objects of a simulation as entities: poses, bounds, placing and pushing.

An entity is a topmost body with all bodies below it; a robot whose root link is the world consists of several topmost bodies.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.geoms import extents
from graphengine.devices.entity import Box, Entity, EntityKind, EntityState, Move, Overlap, refuse
from graphengine.devices.rotation import (
    Pose,
    Quaternion,
    Vector3,
    compose,
    multiply,
    pose_of,
    relative,
    unrotate,
    vector,
)
from graphengine.devices.stage import Prim
from graphengine.format.errors import PhysicsError, UnknownEntityError, UsageError
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.core.robot_reset import robot_reset
from graphengine.physics.dynamics.overlaps import LEAST, contacts_of, distances, overlaps, touching
from graphengine.physics.dynamics.solver_errors import find_contacts
from graphengine.physics.handles.motion_handles import CarriedPrim
from graphengine.physics.handles.touched_geoms import TouchedGeoms, topmost_bodies

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

MOST = 1e6
"""Greatest magnitude of any number in a request, in SI units: 1000 km, or the weight of 100 t."""
REST: Vector3 = (0.0, 0.0, 0.0)
_TURNS = 12
"""Number of headings at which `clearance` looks for obstacles."""


class MujocoEntities:
    """The entities of a simulation.

    Args:
        simulation: the simulation; its current model and state are read at each call.
    """

    def __init__(self, simulation: SimulationCore) -> None:
        self._simulation = simulation
        self._owners: tuple[mujoco.MjModel, dict[int, str]] | None = None
        """Cached result of `_find_owners`, and the model for which it is valid."""
        self._touched: dict[str, TouchedGeoms] = {}
        """A dict from the name of an entity to the handle that `touched` reads."""

    def all(self) -> list[Entity]:
        """Return robots in the order of the stage, then the world's own bodies."""
        found = self._prims().items()
        return [Entity(name, prim.path, self._kind(prim), bool(prim.facts.get("spawned"))) for name, prim in found]

    def _prims(self) -> dict[str, Prim]:
        stage = self._simulation.stage
        prims = stage.robots()
        world = stage.root.children.get("World")
        for prim in world.children.values() if world is not None else ():
            if prim.kind != "robot" and prim.body is not None:
                prims[prim.name if prim.name not in prims else f"World/{prim.name}"] = prim
        return prims

    def _find(self, name: str) -> Prim:
        prims = self._prims()
        prim = prims.get(name) or next((prim for prim in prims.values() if prim.path == name), None)
        if prim is None:
            near = did_you_mean(name, prims) or listing(prims, "entities")
            raise UnknownEntityError(f"no entity {name!r}\n  {near}")
        return prim

    def roots(self, prim: Prim) -> list[int]:
        """Return the ids of the topmost bodies of the entity at a prim."""
        return topmost_bodies(self._simulation.model, prim)

    def _only_root(self, name: str, prim: Prim) -> int:
        """Return the id of an entity's only topmost body; raise UsageError if its root link is the world."""
        if prim.body is None:
            raise UsageError(f"{name} cannot be moved: its root link is the world itself")
        return self.roots(prim)[0]

    def _refuse_mover(self, name: str, prim: Prim, what: str) -> None:
        if self._kind(prim) == "mover":
            remedy = "change its `path`, `speed` or `start` below `movers:` of the scene"
            raise UsageError(f"{name} cannot be {what}: it is a mover, and its path determines its pose\n  {remedy}")

    def _kind(self, prim: Prim) -> EntityKind:
        if prim.facts.get("joints") or prim.facts.get("mounts"):
            return "robot"
        if prim.body in self._simulation.surfaces.velocities:
            return "static"  # only its surface moves
        if prim.body in self._simulation.movers.names:
            return "mover"
        model, roots = self._simulation.model, self.roots(prim)
        own = np.isin(model.body_rootid, roots)
        moves = model.body_weldid[own].any() or (model.body_mocapid[own] >= 0).any()
        return "object" if moves else "static"

    def state(self, name: str) -> EntityState:
        """Return pose, velocity and acceleration of an entity in the world frame."""
        simulation, prim = self._simulation, self._find(name)
        handle = simulation.handles.find(CarriedPrim, prim)
        acceleration = np.zeros(6)
        model, data = simulation.model, simulation.forces.now()
        mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, handle.body, acceleration, 0)
        acceleration[3:] -= data.cacc[0, 3:]  # MuJoCo lets the world accelerate upwards in the place of gravity
        angular, linear = np.split(acceleration, 2)
        return EntityState(*handle.pose(), *handle.velocity(), vector(linear), vector(angular))

    def bounds(self, name: str, *, own: bool = False) -> Box | None:
        """Return the bounding box of an entity in the world frame, or in its own frame if `own` is true; None without geoms."""
        model, data, prim = self._simulation.model, self._simulation.data, self._find(name)
        geoms = np.flatnonzero(np.isin(model.body_rootid[model.geom_bodyid], self.roots(prim)))
        if own:
            body = self._simulation.handles.find(CarriedPrim, prim).body
            found = extents(model, data, geoms, data.xpos[body], data.xmat[body].reshape(3, 3))
        else:
            found = extents(model, data, geoms)
        return Box(vector(found[0]), vector(found[1])) if found is not None else None

    def overlaps(self, name: str, *, floors: bool = True) -> list[Overlap]:
        """Return the overlaps of an entity with other objects, deepest first; see `devices.backend.Entities`."""
        simulation = self._simulation
        return self._named(overlaps(simulation.model, simulation.data, self.roots(self._find(name)), floors=floors))

    def _obstacles(self, name: str, root: int, pose: Pose) -> list[Overlap]:
        """Return the overlaps that an entity would have with its topmost body at a pose, except its present overlaps.

        They are computed in a copy of the state; the simulation does not change.
        """
        model, data = self._copy_at(root, pose)
        find_contacts(model, data)
        now = {overlap.other: overlap.depth for overlap in self.overlaps(name, floors=False)}
        found = self._named(overlaps(model, data, [root], floors=False))
        return [overlap for overlap in found if overlap.depth > now.get(overlap.other, 0.0) + LEAST]

    def clearance(self, name: str, position: tuple[float, float], margin: float) -> dict[str, float]:
        """Return the distances (m) of all that would stand close at another position; see `devices.backend.Entities`."""
        prim = self._find(name)
        _check(name, position=position)
        root, data = self._only_root(name, prim), self._simulation.data
        now = self._simulation.handles.find(CarriedPrim, prim).pose()
        mounted = relative(now, pose_of(data.xpos[root], data.xquat[root]))
        found: dict[str, float] = {}
        there = None
        for step in range(_TURNS):
            half = math.pi * step / _TURNS
            turned = multiply((0.0, 0.0, math.sin(half), math.cos(half)), now[1])
            model, there = self._copy_at(root, compose(((*position, now[0][2]), turned), mounted), there)
            mujoco.mj_kinematics(model, there)
            for geom, distance in distances(model, there, root, margin).items():
                other = self._owner(geom)
                found[other] = min(distance, found.get(other, math.inf))
        return dict(sorted(found.items(), key=lambda item: item[1]))

    def fixed_around(self, body: str) -> str:
        """Return the name of a fixed body, except floors, that overlaps a topmost body; an empty text if none does."""
        model, data = self._simulation.model, self._simulation.data
        found = distances(model, data, int(model.body(body).id), -LEAST)
        return next((self._owner(geom) for geom in found if not model.body_weldid[model.geom_bodyid[geom]]), "")

    def _copy_at(
        self, root: int, pose: Pose, data: mujoco.MjData | None = None
    ) -> tuple[mujoco.MjModel, mujoco.MjData]:
        """Return a copy of the state in which an entity's topmost body is at a pose, with the model of this copy.

        Args:
            root: id of the topmost body.
            pose: pose of the body in the world frame.
            data: an earlier copy, which is used again if the body is not fixed to the world.
        """
        simulation = self._simulation
        model = simulation.model
        if model.body_jntnum[root] == 0:
            model, data = simulation.with_mount(root, pose), None
        if data is None:
            data = mujoco.MjData(model)
            for field in ("qpos", "mocap_pos", "mocap_quat"):
                getattr(data, field)[:] = getattr(simulation.data, field)
        (x, y, z), (qx, qy, qz, qw) = pose
        if (mocap := model.body_mocapid[root]) >= 0:
            data.mocap_pos[mocap], data.mocap_quat[mocap] = (x, y, z), (qw, qx, qy, qz)
        elif model.body_jntnum[root]:
            data.joint(int(model.body_jntadr[root])).qpos[:] = x, y, z, qw, qx, qy, qz
        return model, data

    def touching(self) -> dict[str, Overlap]:
        """Return a dict from the name of each entity that touches a body other than its support to its deepest contact."""
        found = touching(self._simulation.model, self._simulation.data, self._find_owners())
        return {name: Overlap(self._owner(geom), depth) for name, (depth, geom) in found.items()}

    def touched(self, name: str) -> Sequence[str]:
        """Return the names of all bodies that an entity touched in this tick; see `devices.backend.Entities`."""
        handle = self._touched.get(name)
        if handle is None or handle.released:
            handle = self._touched[name] = self._simulation.handles.find(TouchedGeoms, self._find(name))
        geoms = tuple(handle.geoms)
        if geoms != handle.named[0]:
            handle.named = geoms, tuple(dict.fromkeys(map(self._owner, geoms)))
        return handle.named[1]

    def moving(self, speed: float) -> dict[str, list[str]]:
        """Return the entities of which a part moves, each with the names of all that it touches.

        Args:
            speed: smallest speed that counts as motion, m/s and rad/s.
        """
        model, data, owners = self._simulation.model, self._simulation.data, self._find_owners()
        roots = model.body_rootid[model.dof_bodyid[np.abs(data.qvel) >= speed]]
        names = dict.fromkeys(owners[root] for root in roots.tolist() if root in owners)
        touched = {name: contacts_of(model, data, self.roots(self._find(name))) for name in names}
        return {name: list(dict.fromkeys(map(self._owner, geoms))) for name, geoms in touched.items()}

    def _find_owners(self) -> dict[int, str]:
        """Return the names of entities by the ids of their topmost bodies; the result is cached for the current model."""
        model = self._simulation.model
        if self._owners is None or self._owners[0] is not model:
            self._owners = model, {root: name for name, prim in self._prims().items() for root in self.roots(prim)}
        return self._owners[1]

    def _named(self, depths: Mapping[int, float]) -> list[Overlap]:
        """Return overlaps, given as depths (m) by the ids of geoms, with the names of the owners."""
        return [Overlap(self._owner(geom), depth) for geom, depth in depths.items()]

    def _owner(self, geom: int) -> str:
        """Return the name of the entity that has a geom; without one, the geom's own name."""
        model = self._simulation.model
        owner = self._find_owners().get(int(model.body_rootid[model.geom_bodyid[geom]]))
        return owner or model.geom(geom).name or "the world"

    def place(self, name: str, move: Move, *, forced: bool = True) -> None:
        """Place an entity; see `devices.backend.Entities`."""
        prim = self._find(name)
        linear, angular = move.linear or REST, move.angular or REST
        now = self._simulation.handles.find(CarriedPrim, prim).pose()
        _check(name, position=move.position, orientation=move.orientation, velocity=(*linear, *angular))
        turned = _unit(name, move.orientation) if move.orientation is not None else now[1]
        pose = move.position or now[0], turned
        self._refuse_mover(name, prim, "moved")
        root, model, data = self._only_root(name, prim), self._simulation.model, self._simulation.data
        there = compose(pose, relative(now, pose_of(data.xpos[root], data.xquat[root])))
        bolted, joint = model.body_jntnum[root] == 0, int(model.body_jntadr[root])
        if bolted and any((*linear, *angular)):
            raise UsageError(f"{name} is fixed to the world: it can be moved, but cannot have a velocity")
        if not bolted and model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
            named = model.joint(joint).name
            raise UsageError(f"{name} cannot be moved: it is attached to joint {named!r} of the world")
        try:
            if not forced and (move.position is not None or move.orientation is not None):
                refuse(name, self._obstacles(name, root, there))
            if bolted:
                self._simulation.move_mount(root, there)
            else:
                arm = np.subtract(there[0], pose[0])
                self._throw(root, there, np.add(linear, np.cross(angular, arm)).tolist(), angular)
        except PhysicsError as error:
            raise UsageError(f"{name} cannot be placed at this pose: {error}") from error

    def reset(
        self, name: str, move: Move, joints: Mapping[str, float], keyframe: str | None, *, forced: bool = True
    ) -> None:
        """Return a robot to its initial state; see `devices.backend.Entities`."""
        prim, simulation = self._find(name), self._simulation
        if prim.body is not None and simulation.is_moved(self.roots(prim)[0]):
            position, orientation = move.position or prim.position, move.orientation or prim.orientation
            move = replace(move, position=position, orientation=orientation)
        try:
            with robot_reset(simulation, prim, joints, keyframe):
                if move != Move():
                    self.place(name, move, forced=forced)
        except PhysicsError as error:
            raise UsageError(f"{name} cannot be reset to this state: {error}") from error

    def _throw(self, body: int, pose: Pose, linear: Iterable[float], angular: Vector3) -> None:
        """Set pose and velocity (m/s, rad/s) of a free body in the world frame; a held body is released."""
        joint = self._simulation.data.joint(int(self._simulation.model.body_jntadr[body]))
        self._simulation.let_go(body)
        before = joint.qpos.copy(), joint.qvel.copy()
        position, (x, y, z, w) = pose
        joint.qpos[:] = (*position, w, x, y, z)
        joint.qvel[:] = (*linear, *unrotate(pose[1], angular))  # MuJoCo's turn is in the body's frame
        try:
            self._simulation.refresh()
        except PhysicsError:
            joint.qpos[:], joint.qvel[:] = before
            self._simulation.refresh()
            raise

    def push(self, name: str, force: Vector3, duration: float, point: Vector3 | None = None) -> None:
        """Apply a force to an entity for some time; see `devices.backend.Entities`."""
        prim = self._find(name)
        _check(name, force=force, duration=(duration,), point=point)
        if duration <= 0.0:
            raise UsageError(f"{name}: the duration of a push must be greater than 0 s, not {duration:g} s")
        self._refuse_mover(name, prim, "pushed")
        root, model = self._only_root(name, prim), self._simulation.model
        if model.body_jntnum[root] == 0:
            raise UsageError(f"{name} cannot be pushed: it is fixed to the world")
        self._simulation.pushes.add(model.body(root).name, force, duration, point)
        self._simulation.refresh()  # which wakes what sleeps


def _check(name: str, **quantities: Iterable[float] | None) -> None:
    """Raise UsageError if a component of a quantity is not finite or its magnitude exceeds `MOST`.

    Args:
        name: name of the entity, for the message.
        quantities: a dict from the name of each quantity in the message to its components; None for a quantity that is not given.
    """
    for what, values in quantities.items():
        for value in values or ():
            if not abs(value) <= MOST:
                raise UsageError(f"{name}: invalid {what} {value:g}; legal: at most {MOST:g}")


def _unit(name: str, orientation: Quaternion) -> Quaternion:
    length = math.hypot(*orientation)
    if length < 1e-6:
        raise UsageError(f"{name}: (0, 0, 0, 0) is not an orientation; use (0, 0, 0, 1) for no rotation")
    x, y, z, w = (value / length for value in orientation)
    return x, y, z, w
