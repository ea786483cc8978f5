"""Computes the gains of an arm's position drives from its mass matrix, weight and effort limits.

A joint exerts its full effort at a deviation of 10 mrad or 10 mm, so a payload deflects the joint by less. Without an effort
limit, the stiffness is that of a servo of 5 Hz that moves all joints at once, because their inertias are coupled. A quarter of
the deviation suffices against the joint's own damping and friction at half the speed limit. The damping of a drive is at least
critical for the largest inertia that the joint moves in a set of poses, and at least that of a servo of 5 Hz: with less damping,
an arm overshoots when its target jumps, because its motors are too weak to stop it in time. Commanded velocities compensate for
the lag.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graphengine.bringup.robots.trial import trial
from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft, rounded

DEVIATION = 0.01
"""Deviation at which a drive exerts its full effort, rad or m."""
FASTEST = 5.0
"""Maximum bandwidth of a drive, Hz."""
LAG = 0.0025
"""Maximum deviation, rad or m, that a joint's own damping and friction cause at half its speed limit."""
STOPPING = 0.5
"""Distance (rad or m) from the speed limit to a stop above which the effort limit of a joint is reported."""
POSES = 64
"""Number of random poses, within the limits of all joints, in which inertias and weights are computed."""
_MOST = 1e9
"""Maximum stiffness, N m/rad or N/m."""


@dataclass(frozen=True, slots=True)
class Load:
    """The largest loads of a joint in any of the poses.

    Attributes:
        inertia: largest diagonal element of the mass matrix for this joint, kg m2 or kg.
        coupled: largest effort (N m or N) that the joint needs if all joints accelerate at 1 rad/s2 or 1 m/s2, each in the
            direction that needs most.
        weight: largest effort that the joint needs to hold its links against gravity, N m or N.
    """

    inertia: float
    coupled: float
    weight: float


def set_gains(draft: Draft) -> None:
    """Set the gains of the position drives in `draft.servos`, because the description gives none.

    These drives also get gravity compensation and interpolation of set points.
    """
    joints = [draft.description.joints[name] for name in draft.servos]
    loads = _loads(draft, joints) if joints else None
    if loads is None:
        return
    bandwidths: list[float] = []
    weak: list[str] = []
    slow: list[str] = []
    for joint, load in zip(joints, loads, strict=True):
        stiffness, bandwidth = _gains(joint, load)
        bandwidths.append(bandwidth)
        entry = draft.joints[joint.name]
        drive = entry.value["drive"]
        drive["stiffness"], drive["damping"] = stiffness, rounded(stiffness / (math.pi * bandwidth), 3)
        drive |= {"interpolate": True, "gravity_compensation": True}
        unit = "kg" if joint.type == "prismatic" else "kg m2"
        entry.hint = f"{bandwidth:.1f} Hz, at least critically damped up to {rounded(load.inertia, 3):g} {unit}"
        if joint.effort is not None and load.weight > joint.effort:
            weak.append(f"{joint.name} ({joint.effort:g} of {load.weight:.3g})")
        elif (way := _stopping(joint, load)) > STOPPING:
            slow.append(f"{joint.name} ({way:.2g} from {joint.velocity:g}/s)")
    slowest, fastest = min(bandwidths), max(bandwidths)
    rate = f"{slowest:.1f} to {fastest:.1f} Hz" if f"{slowest:.1f}" != f"{fastest:.1f}" else f"{slowest:.1f} Hz"
    text = f"gains of position drives: {rate}, at least critically damped by the mass matrix; full effort at 10 mrad or 10 mm; "
    draft.guess(text + "gravity_compensation and interpolate", joints[0].element.span)
    if weak:
        text = f"effort limits below the weight that a joint carries in some poses, N m or N: {', '.join(weak)}"
        remedy = "there the joint sinks; max_force of a drive replaces the limit"
        draft.notice(f"{text}; {remedy}", joints[0].element.span)
    if slow:
        text = "effort limits with which joints need a long way to stop from their speed limits in some poses, "
        text += f"rad or m: {', '.join(slow)}; they lag behind trajectories that need more acceleration"
        draft.notice(text, joints[0].element.span)


def _stopping(joint: Joint, load: Load) -> float:
    """Return the distance (rad or m) in which a joint stops from its speed limit with full effort; 0 without these limits."""
    if not joint.effort or not joint.velocity:
        return 0.0
    free = joint.effort - load.weight
    return joint.velocity**2 * load.inertia / (2.0 * free) if free > 0.0 else math.inf


def _gains(joint: Joint, load: Load) -> tuple[float, float]:
    """Return the stiffness (N m/rad or N/m) and bandwidth (Hz) of the drive of a joint."""
    fastest = 2 * math.pi * FASTEST
    most = joint.effort or max(load.weight, load.coupled * fastest**2 * DEVIATION)
    damping, friction = joint.losses
    lost = damping * (joint.velocity or 0.0) / 2 + friction
    stiffness = rounded(min(max(most / DEVIATION, lost / LAG, 1e-6 / DEVIATION), _MOST), 3)
    natural = math.sqrt(stiffness / load.inertia) if load.inertia > 0 else fastest
    return stiffness, min(natural, fastest) / (2 * math.pi)


def _loads(draft: Draft, joints: Sequence[Joint]) -> list[Load] | None:
    """Return the largest loads of each joint in a fixed set of poses; None if the robot cannot be compiled."""
    if (model := trial(draft)) is None:
        return None
    data, random = mujoco.MjData(model), np.random.default_rng(0)
    scalar = np.flatnonzero(model.jnt_type != mujoco.mjtJoint.mjJNT_FREE)
    places, dofs = model.jnt_qposadr[scalar], [int(model.joint(joint.name).dofadr[0]) for joint in joints]
    limited = model.jnt_limited[scalar] != 0
    lowest = np.where(limited, model.jnt_range[scalar, 0], -math.pi)
    highest = np.where(limited, model.jnt_range[scalar, 1], math.pi)
    inertias, coupled, weights = np.zeros((3, len(joints)))
    efforts, matrix = np.zeros(model.nv), np.zeros((model.nv, model.nv))
    for _ in range(POSES):
        data.qpos[places] = random.uniform(lowest, highest)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        mujoco.mj_rne(model, data, 0, efforts)
        mujoco.mj_fullM(model, data, matrix)
        own = matrix[np.ix_(dofs, dofs)]
        inertias = np.maximum(inertias, own.diagonal())
        coupled = np.maximum(coupled, np.abs(own).sum(1))
        weights = np.maximum(weights, np.abs(efforts[dofs]))
    return [Load(*each) for each in zip(inertias.tolist(), coupled.tolist(), weights.tolist(), strict=True)]
