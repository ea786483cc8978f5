"""The most that drives exert, kept by a limit on how far their set points run ahead of the joints.

MuJoCo's own limits on force (`forcerange`, `actuatorfrcrange`) do not go with stiff drives: a servo that they cut off loses its
implicit damping, no longer feels the velocity that it causes, and rattles about its target. So nothing is cut off here; what a
set point asks for is brought down beforehand, to what the force can do in a step.

At the end of a step of length h a drive exerts F = f - G dv / h. Here f is its force as if the joint went on at its velocity v,
kp (q* - q - h v) + kd (v* - v), G = h (kd + h kp) is what MuJoCo solves implicitly, and dv is the change of velocity. With the
inertia I that the joint moves, and the force b that gravity takes, dv = h (F - b) / I. So F stays within a maximum M if f stays
between -M - (M + b) G / I and M + (M - b) G / I; of a set point further ahead, the joint follows a slope of M / I.

I is that of the links beyond the joint with all joints at zero, and for a wheel also its share of the robot, m r² / wheels. Where
something else resists, a load or a wall, F exceeds M by a part of that; in a joint held fast, by the factor 1 + G / I.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from graphengine.diagnostics import Findings
from graphengine.world.drives import Drive, position_servo, servos, velocity_servo
from graphengine.world.engine import mujoco
from graphengine.world.robot import Robot

CLOSELY = 1.1
"""How far a force may exceed its maximum without a note."""


class ForceLimits:
    """Those drives of a model that have a maximum force.

    Args:
        model: compiled; its timestep is the step.
        data: of the simulation.
        drives: with the names of their joints in the model.

    Attributes:
        joints: names of the joints.
        inertias: I of each, kg m² or kg.
        resisted: 1 + G / I of each.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Iterable[tuple[str, Drive]]) -> None:
        limited = [(name, drive) for name, drive in drives if drive.max_force < np.inf]
        self.joints = [name for name, _ in limited]
        ids = np.array([model.joint(name).id for name in self.joints], np.intp)
        table = [(drive.stiffness, drive.damping, drive.max_force, drive.carries) for _, drive in limited]
        self._stiffness, self._damping, self._most, carries = np.array(table, float).reshape(-1, 4).T
        self._position_servos = servos(model, map(position_servo, self.joints), self._stiffness)
        self._velocity_servos = servos(model, map(velocity_servo, self.joints), self._damping)
        self._coordinates, self._dofs = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        self._data, self._step = data, model.opt.timestep
        masses = model.body_subtreemass[model.body_rootid[model.jnt_bodyid[ids]]]
        self.inertias = model.dof_M0[self._dofs] + carries * masses
        self._implicit = self._step * (self._damping + self._step * self._stiffness) / self.inertias
        self.resisted = 1.0 + self._implicit

    def apply(self, efforts: NDArray[np.float64]) -> None:
        """Take off what drives would exert in excess in the next step; what joints were told to exert besides stays."""
        data, dofs = self._data, self._dofs
        velocities, gravity = data.qvel[dofs], data.qfrc_bias[dofs]
        ahead = data.ctrl[self._position_servos] - data.qpos[self._coordinates] - self._step * velocities
        forces = self._stiffness * ahead + self._damping * (data.ctrl[self._velocity_servos] - velocities)
        lowest = -self._most - self._implicit * (self._most + gravity)
        highest = self._most + self._implicit * (self._most - gravity)
        data.qfrc_applied[dofs] = efforts[dofs] - (forces - np.clip(forces, lowest, highest))


def tell_limits(limits: ForceLimits, robots: Mapping[str, Robot], findings: Findings) -> None:
    """Tell what maximum forces come to: those that robot files state, and those of descriptions that are not kept closely."""
    told: set[tuple[int, str]] = set()
    for name, inertia, resisted in zip(limits.joints, limits.inertias.tolist(), limits.resisted.tolist(), strict=True):
        owner, _, joint = name.partition("/")
        robot = robots[owner]
        most, spec = robot.drives[joint].max_force, robot.spec.joints[joint]
        drive = spec.drive or spec.usd_drive
        stated = drive is not None and drive.max_force is not None
        if (id(robot.file), joint) in told or not (stated or resisted > CLOSELY):
            continue
        told.add((id(robot.file), joint))
        sliding = robot.urdf.joints[joint].type == "prismatic"
        force, mass, slope = ("N", "kg", "m/s2") if sliding else ("N m", "kg m2", "rad/s2")
        limit = f"{'max_force' if stated else 'the effort in the description,'} {most:g} {force}"
        text = f"joint {joint!r}: {limit} accelerates its {inertia:.3g} {mass} by at most {most / inertia:.3g} {slope}"
        more = f"held fast, it may exert {most * resisted:.3g} {force}: less damping or more substeps bring that down"
        span = robot.file.key_span("joints", joint, "drive" if spec.drive is not None else "usd_drive")
        findings.add("N103", text, span, more if resisted > CLOSELY else "")
