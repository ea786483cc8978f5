"""Bodies that graphs place and hold at a pose; no force moves these bodies.

A body on a free joint can have any pose; a body on a hinge or slide joint is placed as close to a pose as the joint allows. The
joint's coordinates are written back after each physics step, before MuJoCo computes the contacts of the new state. While the body
is held, its joint has a very large inertia. So the body is as firm as the ground for bodies that lean on it. With its own inertia
it would give way, and a heavy body would sink through a light one.
"""

from __future__ import annotations

import math

import numpy as np

from graphengine.descriptions.engine import Floats, Indices, mujoco
from graphengine.devices import rotation
from graphengine.devices.rotation import NOWHERE, Pose, Quaternion, Vector3, pose_of, vector
from graphengine.devices.stage import Prim, Stage
from graphengine.format.errors import PhysicsError

_FREE, _SLIDE = mujoco.mjtJoint.mjJNT_FREE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
_PLACEABLE = (_FREE, _SLIDE, mujoco.mjtJoint.mjJNT_HINGE.value)
_FIRM = 1e8
"""Inertia added to the joint of a held body, kg or kg m2."""
_SOFTNESS = 1e-2
"""Factor by which the inverse weights of a held body are reduced; the smaller these weights, the firmer its contacts."""


def find_mover(model: mujoco.MjModel, stage: Stage, prim: Prim) -> tuple[int, Pose] | None:
    """Return the id of the body that moves when a prim is placed, and the prim's pose in that body's frame.

    The body is the prim's own body. For a prim that stands for a whole robot, it can also be a body to which the robot is fixed.
    Other links that are fixed to a body cannot be placed, because the whole robot would move.

    Returns:
        Id and pose; None if the prim cannot be placed, because the body does not have exactly one free, hinge or slide joint.
    """
    name, pose = prim.carrier()
    leads = stage.stands_for_robot(prim) is not None
    if name is None or not (leads or prim.body is not None):
        return None
    body = int(model.body(name).id)
    while leads and body and not model.body_jntnum[body]:
        pose = rotation.compose(pose_of(model.body_pos[body], model.body_quat[body]), pose)
        body = int(model.body_parentid[body])
    joints = model.jnt_type[model.body_jntadr[body] :][: model.body_jntnum[body]].tolist()
    return (body, pose) if len(joints) == 1 and joints[0] in _PLACEABLE else None


class HeldBody:
    """A body that is held at a pose.

    Args:
        model: compiled model.
        data: state of the model.
        stage: prims of the model.
        prim: the prim that is placed; `find_mover` must find a body for it.
        coordinates: coordinates of the joint at which the body is already held; None if it is not held yet.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, stage: Stage, prim: Prim, coordinates: Floats | None = None
    ) -> None:
        self.coordinates = coordinates
        self._stage, self._prim = stage, prim
        self._loose: list[Floats] = []
        self.bind(model, data)

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Look up the body that moves with the prim, and its joint, in a model; if the body is held, make it firm."""
        self._model, self._data = model, data
        mover = find_mover(model, self._stage, self._prim)
        assert mover is not None
        self.body, self._offset = mover
        body = self.body
        self._joint = joint = int(model.body_jntadr[body])
        self._position, self._velocity = data.joint(joint).qpos, data.joint(joint).qvel
        dof = int(model.jnt_dofadr[joint])
        self._dofs = slice(dof, dof + len(self._velocity))
        if self.coordinates is not None:
            self.make_firm()

    def aim(self, position: Vector3, orientation: Quaternion) -> None:
        """Set the pose in the world frame at which `hold` holds the prim.

        Raises:
            PhysicsError: a number is outside MuJoCo's range; nothing has changed.
        """
        of_body = rotation.compose((position, orientation), rotation.relative(self._offset, NOWHERE))
        coordinates = self._towards(*of_body)
        if not np.abs(coordinates).max() <= mujoco.mjMAXVAL:
            legal = f"coordinates must be at most {mujoco.mjMAXVAL:g} m"
            raise PhysicsError(f"{self._prim.path} cannot be put at {position}, {orientation}; {legal}")
        self.coordinates = coordinates

    def hold(self) -> None:
        """Write the held pose and zero velocity to the state."""
        self._position[:] = self.coordinates
        self._velocity[:] = 0.0

    def soften(self) -> None:
        """Restore the body's own inertia and inverse weights in the model."""
        for (array, where, _, _), loose in zip(self._weights(), self._loose, strict=True):
            array[where] = loose

    def make_firm(self) -> None:
        """Give the body its large inertia and small inverse weights in the model."""
        self._loose = [np.copy(array[where]) for array, where, _, _ in self._weights()]
        for array, where, factor, more in self._weights():
            array[where] = array[where] * factor + more

    def _weights(self) -> list[tuple[Floats, slice | Indices, float, float]]:
        """Return MuJoCo's arrays that determine how easily the body moves.

        Each array comes with the indices of the body's entries, and with the factor and summand that make these entries firm.
        The first two arrays are inertias; MuJoCo uses `dof_M0` for bodies whose inertia matrix is diagonal. The last two are
        inverse weights, which soften contacts. They must not become zero: the contact force on a body that is held inside the
        ground would be unbounded.
        """
        model = self._model
        return [
            (model.dof_armature, self._dofs, 1.0, _FIRM),
            (model.dof_M0, self._dofs, 1.0, _FIRM),
            (model.dof_invweight0, self._dofs, _SOFTNESS, 0.0),
            (model.body_invweight0, np.flatnonzero(model.body_weldid == self.body), _SOFTNESS, 0.0),
        ]

    def _towards(self, position: Vector3, orientation: Quaternion) -> Floats:
        """Return the joint coordinates that bring the body to a pose in the world, or as close to it as the joint allows."""
        model, data, body, joint = self._model, self._data, self.body, self._joint
        x, y, z, w = orientation
        if model.jnt_type[joint] == _FREE:
            return np.array((*position, w, x, y, z))
        parent = int(model.body_parentid[body])
        offset, turn = rotation.relative(pose_of(data.xpos[parent], data.xquat[parent]), (position, orientation))
        axis, (_, rest) = vector(model.jnt_axis[joint]), pose_of(model.body_pos[body], model.body_quat[body])
        if model.jnt_type[joint] == _SLIDE:
            way = float(np.dot(np.subtract(offset, model.body_pos[body]), rotation.rotate(rest, axis)))
        else:
            *part, w = rotation.multiply(rotation.conjugate(rest), turn)
            angle = 2.0 * math.atan2(float(np.dot(part, axis)), w)
            present = float(self._position[0] - model.qpos0[model.jnt_qposadr[joint]])
            way = present + math.remainder(angle - present, math.tau)  # a wheel goes the short way
        way += float(model.qpos0[model.jnt_qposadr[joint]])
        return np.array([np.clip(way, *model.jnt_range[joint]) if model.jnt_limited[joint] else way])
