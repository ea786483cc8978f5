"""Describes errors of MuJoCo's solver, with remedies."""

from __future__ import annotations

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.format.errors import PhysicsError
from graphengine.physics.dynamics.directed_friction import DirectedFriction


def gave_up(data: mujoco.MjData, error: Exception) -> PhysicsError:
    """Return the error to raise for an exception that MuJoCo raised in a step, for example because of degenerate geometry."""
    return PhysicsError(f"at t = {data.time:.4f} s MuJoCo gave up: {error}\nlook for degenerate geometry in the scene")


def begin_step(model: mujoco.MjModel, data: mujoco.MjData, directed: DirectedFriction) -> None:
    """Compute the poses, velocities and contacts of a state: the first half of a step.

    Args:
        model: model of the state.
        data: state, which is changed.
        directed: adjusts the contacts of geoms whose friction depends on the direction.

    Raises:
        PhysicsError: MuJoCo reported a fatal error.
    """
    try:
        mujoco.mj_step1(model, data)
        directed.apply()
    except mujoco.FatalError as error:
        raise gave_up(data, error) from error


def find_contacts(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute only the poses and contacts of a state.

    Raises:
        PhysicsError: MuJoCo reported a fatal error.
    """
    try:
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
    except mujoco.FatalError as error:
        raise gave_up(data, error) from error


def out_of_range(model: mujoco.MjModel, data: mujoco.MjData) -> PhysicsError:
    """Return the error to raise for a body whose position is outside MuJoCo's range of coordinates."""
    coordinate = data.warning[mujoco.mjtWarning.mjWARN_BADQPOS].lastinfo
    joint = int(np.searchsorted(model.jnt_qposadr, coordinate, side="right")) - 1
    body = model.body(model.jnt_bodyid[joint]).name
    return PhysicsError(f"{body!r} is farther from the world's origin than {mujoco.mjMAXVAL:g} m")


def diverged(model: mujoco.MjModel, data: mujoco.MjData) -> PhysicsError:
    """Return the error to raise for the warnings that MuJoCo counted in a step; its message suggests remedies."""
    kinds, counts = mujoco.mjtWarning, data.warning.number
    at = f"at t = {data.time:.4f} s"
    if counts[kinds.mjWARN_CONTACTFULL] or counts[kinds.mjWARN_CNSTRFULL]:
        return PhysicsError(f'{at}: no memory left for contacts\ngive the world more: <size memory="100M"/>')
    if counts[kinds.mjWARN_INERTIA] and np.isfinite(data.qvel).all():
        joint = int(model.dof_jntid[data.warning[kinds.mjWARN_INERTIA].lastinfo])
        name = model.joint(joint).name or model.body(model.jnt_bodyid[joint]).name
        what = f"{at}: MuJoCo cannot solve for the motion of {name!r}"
        return PhysicsError(f"{what}\ngive its joint an armature, or its links more inertia")
    # MuJoCo tells the last coordinate that it found; the fastest is the one to look at.
    joint = int(model.dof_jntid[np.argmax(np.nan_to_num(np.abs(data.qvel), nan=np.inf))])
    body = model.body(model.jnt_bodyid[joint]).name
    return PhysicsError(
        f"the simulation diverged {at}: the motion of joint {model.joint(joint).name!r} of body {body!r} is without bounds\n"
        "raise physics.substeps, lower the drive's damping or stiffness, give it a max_acceleration, "
        "or give the joint an armature\n"
        "if it was moved, spawned or pushed: place it clear of other bodies, or push it less"
    )
