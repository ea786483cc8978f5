"""Imports MuJoCo for the whole package, turns off its log file, and reports an unusable installation.

By default, MuJoCo prints each warning and appends it to ./MUJOCO_LOG.TXT. MuJoCo also counts warnings in MjData, where
`SimulationCore` reads the counts.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from graphengine.format.errors import PhysicsError, UsageError

try:
    import mujoco as mujoco  # the name is exported
except RuntimeError as error:  # of the only setting that is read on import
    remedy = "unset it; images are always rendered with EGL or OSMesa"
    raise UsageError(f"MUJOCO_GL={os.environ.get('MUJOCO_GL')}: not a value that MuJoCo knows\n  {remedy}") from error

OLDEST = (4, 0, 1)
"""The oldest version of MuJoCo whose sparse solver gives correct results."""
if tuple(map(int, re.findall(r"\d+", mujoco.__version__)[:3])) < OLDEST:
    reason = "before 4.0.1, its solver gives wrong results for bodies with many contacts"
    remedy = "pip uninstall mujoco mujoco-core, then pip install 'mujoco-core>=4.0.1,<4.1'"
    raise UsageError(f"MuJoCo {mujoco.__version__} is installed; {reason}\n  {remedy}")

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Bools = NDArray[np.bool_]

REFUSALS = (ValueError, RuntimeError, MemoryError, mujoco.FatalError, mujoco.UnexpectedError)
"""Exceptions that MuJoCo raises if it cannot read or compile a model, or if the memory is insufficient."""


if mujoco.get_mju_user_warning() is None:
    mujoco.set_mju_user_warning(lambda _: None)  # `SimulationCore` counts the warnings

RAYS_AND_PICTURES = 0
"""Geom group of geoms that are visible to rays and to cameras."""
PICTURES = 2
"""Geom group of geoms that are visible only to cameras: visuals of a body that also has colliders."""
RAYS = 3
"""Geom group of geoms that are visible only to rays: colliders that are hidden from cameras."""
NEITHER = 4
"""Geom group of geoms that are visible neither to rays nor to cameras."""
OWN = 5
"""Geom group of a robot's geoms while sensors of this robot cast rays; the rays pass through these geoms."""

TIGHT_SOLREF = (0.005, 1.0)
"""MuJoCo's `solref` of a weld or of a mimic joint: time constant (s) and damping ratio."""
TIGHT_SOLIMP = (0.999, 0.9999)
"""First values of MuJoCo's `solimp` (impedance); 10 N on a weld, or 30 N on a mimic joint, displace it by micrometres."""


def body_names(model: mujoco.MjModel) -> list[str]:
    """Return the names of all bodies of a model, in the order of their ids."""
    return [model.body(index).name for index in range(model.nbody)]


def all_bodies(spec: mujoco.MjSpec) -> Iterator[mujoco.MjsBody]:
    """Yield the world and all bodies of a specification, in the order of `spec.bodies`, which takes quadratic time."""
    pending = [spec.worldbody]
    while pending:
        body = pending.pop()
        yield body
        pending.extend(reversed(list(body.bodies)))


def collides(model: mujoco.MjModel) -> Bools:
    """Return for each geom whether it can collide with anything."""
    solid: Bools = (model.geom_contype | model.geom_conaffinity) != 0
    return solid


def sort_geoms(model: mujoco.MjModel) -> None:
    """Assign each geom to one of the geom groups of this module. A ray then hits each surface only once.

    Rays hit colliders, and the visuals of bodies without colliders. Cameras see all geoms that were in groups 0 to 2 before.
    """
    solid, pictures = collides(model), model.geom_group <= 2
    rays = solid | ~np.isin(model.geom_bodyid, model.geom_bodyid[solid])
    seen = [rays & pictures, rays, pictures]
    model.geom_group[:] = np.select(seen, [RAYS_AND_PICTURES, RAYS, PICTURES], NEITHER)


def round_weights(model: mujoco.MjModel) -> None:
    """Round the inverse weights of bodies, degrees of freedom and tendons to single precision.

    These weights soften contacts and joint limits. The compiler computes them by vectorised sums over all degrees of freedom;
    therefore their last bits depend on the index of a body in the model. All other compiled values of a body are independent of
    the index.
    """
    for weights in (model.body_invweight0, model.dof_invweight0, model.tendon_invweight0):
        weights[:] = weights.astype(np.float32)


def compiled(spec: mujoco.MjSpec) -> tuple[mujoco.MjModel, list[str]]:
    """Compile a model; return it with MuJoCo's warnings. Raises one of REFUSALS if MuJoCo refuses the model."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = spec.compile()
    return model, [str(warning.message).partition(" Time =")[0] for warning in caught]


def model_bytes(model: mujoco.MjModel) -> bytes:
    """Return a compiled model in MuJoCo's binary format; equal models have equal bytes."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def data_at_start(model: mujoco.MjModel) -> mujoco.MjData:
    """Return the initial state of a model; a joint whose limits exclude zero starts at the nearer limit.

    Raises:
        PhysicsError: there is not enough memory.
    """
    try:
        data = mujoco.MjData(model)
    except REFUSALS as error:
        raise PhysicsError(f"MuJoCo cannot allocate the state of the model: {error}") from error
    scalar = (model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE) | (model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE)
    limited = np.flatnonzero(scalar & (model.jnt_limited != 0))
    places, (lowest, highest) = model.jnt_qposadr[limited], model.jnt_range[limited].T
    data.qpos[places] = np.clip(data.qpos[places], lowest, highest)
    return data


def wake(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Wake all sleeping bodies; MuJoCo does not wake them when gravity, friction or their support changes."""
    flags = model.opt.enableflags
    model.opt.enableflags = flags & ~mujoco.mjtEnableBit.mjENBL_SLEEP.value
    mujoco.mj_kinematics(model, data)  # while sleeping is disabled, it wakes all sleeping bodies
    model.opt.enableflags = flags
