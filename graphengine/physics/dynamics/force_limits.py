"""The most that drives exert, kept by a limit on how far their set points run ahead of the joints.

MuJoCo's own limits on force (`forcerange`, `actuatorfrcrange`) do not go with stiff drives: a servo that they cut off loses its
implicit damping, no longer feels the velocity that it causes, and rattles about its target. So nothing is cut off here; what a
set point asks for is brought down beforehand, to what the force can do in a step.

At the end of a step of length h a drive exerts F = f - G a. Here f is its force as if the joint went on at its velocity v,
kp (q* - q - h v) + kd (v* - v), G = h (kd + h kp) is what MuJoCo solves implicitly, and a is the joint's acceleration in the
step. With the inertia I that the joint moves, and the force b that gravity takes, a free joint at the maximum M has
a = (M - b) / I. So F stays within M if f stays between -M - s (M + b) G / I and M + s (M - b) G / I. Here s says how freely the
joint moves: the share of its forces in the last step that went into acceleration, 1 for a free joint and 0 for one held fast. For
a joint that comes free, 1 + s G / I at most doubles from step to step, or it would bounce off a wall and be thrown back at it.

What comes as a surprise, as a wall that a joint runs into, is opposed with more than M, as by an additional inertia G.

I is that of the links beyond the joint with all joints at zero, and for a wheel also its share of the robot, m r² / wheels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from graphengine.format.diagnostics import Findings
from graphengine.format.stateful import Stateful
from graphengine.physics.engine import Floats, mujoco
from graphengine.physics.model.drives import Drive, servo_ids
from graphengine.physics.model.robot import RobotInstance

_NOTHING = 1e-9
"""Share of a maximum force below which a force tells nothing about how freely a joint moves."""


class ForceLimits(Stateful):
    """The drives of a model that have a maximum force.

    Args:
        model: compiled model; its timestep is the step.
        data: state of the simulation.
        drives: drives by the names of their joints in the model.

    Attributes:
        joints: names of the joints.
        inertias: I of each joint, kg m² or kg.
    """

    kept = ("_reach",)

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Iterable[tuple[str, Drive]]) -> None:
        limited = [(name, drive) for name, drive in drives if drive.max_force < np.inf]
        self.joints = [name for name, _ in limited]
        ids = np.array([model.joint(name).id for name in self.joints], np.intp)
        table = [(drive.stiffness, drive.damping, drive.max_force, drive.carries) for _, drive in limited]
        self._stiffness, self._damping, self._most, carries = np.array(table, float).reshape(-1, 4).T
        self._position_servos, self._velocity_servos, _ = servo_ids(model, limited)
        self._coordinates, self._dofs = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
        self._data, self._step = data, model.opt.timestep
        masses = model.body_subtreemass[model.body_rootid[model.jnt_bodyid[ids]]]
        self.inertias = model.dof_M0[self._dofs] + carries * masses
        self._implicit = self._step * (self._damping + self._step * self._stiffness) / self.inertias
        self.start()

    def start(self) -> None:
        """Assume that all joints move freely."""
        self._reach = 1.0 + self._implicit

    def carry_over(self, old: ForceLimits) -> None:
        """Take over the state of joints that another model's limits also have."""
        known = dict(zip(old.joints, old._reach.tolist(), strict=True))
        self._reach = np.array([known.get(joint, free) for joint, free in zip(self.joints, self._reach, strict=True)])

    def _forces(self, ahead: float) -> Floats:
        """Return the forces of the drives after `ahead` seconds, if the joints keep their velocities."""
        data, velocities = self._data, self._data.qvel[self._dofs]
        positions = data.qpos[self._coordinates] + ahead * velocities
        forces: Floats = self._stiffness * (data.ctrl[self._position_servos] - positions)
        forces += self._damping * (data.ctrl[self._velocity_servos] - velocities)
        return forces

    def observe(self) -> None:
        """Measure how freely joints moved in the last step, before set points move; commanded efforts are part of the forces."""
        data, dofs = self._data, self._dofs
        exerted, moved = self._forces(0.0) + data.qfrc_applied[dofs], self.inertias * data.qacc_warmstart[dofs]
        left = exerted - data.qfrc_bias[dofs]
        told = np.minimum(np.abs(exerted), np.abs(left)) > _NOTHING * self._most
        freely = np.divide(moved, left, out=np.ones_like(left), where=told)
        self._reach = np.minimum(1.0 + self._implicit * np.minimum(np.maximum(freely, 0.0), 1.0), 2.0 * self._reach)

    def apply(self, efforts: Floats, compensation: Floats | None = None) -> None:
        """Reduce the forces of drives that would exceed their maximum in the next step; commanded efforts are unchanged.

        Args:
            efforts: commanded efforts of all degrees of freedom, N m or N.
            compensation: efforts of gravity compensation, which are part of the drives' forces.
        """
        own, forces = efforts[self._dofs], self._forces(self._step)
        added = own
        if compensation is not None:
            added = own + compensation[self._dofs]
            forces += compensation[self._dofs]
        middle = (self._reach - 1.0) * (own - self._data.qfrc_bias[self._dofs])
        most = self._most * self._reach
        legal = np.minimum(np.maximum(forces, middle - most), middle + most)
        self._data.qfrc_applied[self._dofs] = added - (forces - legal)


def tell_limits(limits: ForceLimits, robots: Mapping[str, RobotInstance], findings: Findings) -> None:
    """Add notes on the accelerations to which maximum forces in robot files limit joints."""
    told: set[tuple[int, str]] = set()
    for name, inertia in zip(limits.joints, limits.inertias.tolist(), strict=True):
        owner, _, joint = name.partition("/")
        robot = robots[owner]
        spec = robot.spec.joints[joint]
        key, drive = ("drive", spec.drive) if spec.drive is not None else ("usd_drive", spec.usd_drive)
        if (id(robot.file), joint) in told or drive is None or drive.max_force is None:
            continue
        told.add((id(robot.file), joint))
        sliding = robot.urdf.joints[joint].type == "prismatic"
        force, mass, slope = ("N", "kg", "m/s2") if sliding else ("N m", "kg m2", "rad/s2")
        most = drive.max_force
        text = (
            f"max_force {most:g} {force} accelerates its {inertia:.3g} {mass} by at most {most / inertia:.3g} {slope}"
        )
        findings.add("N103", f"joint {joint!r}: {text}", robot.file.key_span("joints", joint, key))
