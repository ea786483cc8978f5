"""Keeps drives within their maximum forces, by reducing before each step the force that their set points demand.

MuJoCo's own force limits (`forcerange`, `actuatorfrcrange`) do not work with stiff drives: a servo with a clipped force loses its
implicit damping, and its joint oscillates about the target. So the force of a step is not clipped; its demand is reduced.

A drive has the stiffness kp, the damping kd, the set points q* and v*, and the maximum force M. Its joint has the position q, the
velocity v, and the acceleration a in a step of length h. At the end of the step, the drive exerts F = f - G a. The demand f is
the force that the drive would exert if the joint kept its velocity: f = kp (q* - q - h v) + kd (v* - v). MuJoCo solves G a
implicitly, with G = h (kd + h kp). A free joint at maximum force accelerates the inertia I against the gravity force b with
a = (M - b) / I. So F stays within M if f stays between -M - s (M + b) G / I and M + s (M - b) G / I.

The factor s states how freely the joint moves. It is the share of the joint's forces that became acceleration in the last step: 1
for a free joint, 0 for a blocked joint. F - b and a have opposite signs if, for example, friction brakes a joint harder than its
drive accelerates the joint. Then s is 1 if G |a| exceeds |F - b|, else 0. From one step to the next, 1 + s G / I at most doubles;
otherwise the drive would throw a joint that leaves a wall back at it again and again. In the step in which a joint hits an
obstacle, its drive exerts more than M, as if the joint had the additional inertia G.

I is the inertia of the links beyond the joint with all joints at zero. For a wheel of radius r, it includes the wheel's share of
the robot's mass m, m r² divided by the number of wheels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from graphengine.descriptions.actuators.drives import Drive, servo_ids
from graphengine.descriptions.engine import Floats, mujoco
from graphengine.format.diagnostics import Findings
from graphengine.format.stateful import Stateful
from graphengine.physics.kernels.optional_kernels import record
from graphengine.physics.model.robot import RobotInstance

_NOTHING = 1e-9
"""Fraction of a drive's maximum force; a smaller force does not suffice to measure how freely the joint moves."""

LIMITED = record("dof coordinate position_servo velocity_servo", "stiffness damping most nothing inertia implicit")
"""A drive with a maximum force, for `drive_kernel`: indices of its joint and actuators, kp, kd, M, `_NOTHING` M, I, and G / I."""


class ForceLimits(Stateful):
    """Limits the forces of all drives of a model for which a maximum force is given.

    Args:
        model: compiled model; its timestep is the step.
        data: state of the simulation.
        drives: drives by the names of their joints in the model.

    Attributes:
        joints: names of the joints of these drives.
        inertias: inertia that each of these joints moves, kg m² or kg.
        reach: 1 + s G / I of each of these joints.
        table: the drives as records of `LIMITED`.
    """

    kept = ("reach",)

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Iterable[tuple[str, Drive]]) -> None:
        limited = [(name, drive) for name, drive in drives if drive.max_force < np.inf]
        self.joints = [name for name, _ in limited]
        ids = np.array([model.joint(name).id for name in self.joints], np.intp)
        table = [(drive.stiffness, drive.damping, drive.max_force, drive.carries) for _, drive in limited]
        self._stiffness, self._damping, self._most, carries = np.array(table, float).reshape(-1, 4).T
        self._position_servos, self._velocity_servos, _ = servo_ids(model, limited)
        self._coordinates = model.jnt_qposadr[ids].astype(np.intp)
        self._dofs = dofs = model.jnt_dofadr[ids].astype(np.intp)
        self._step = model.opt.timestep
        self._positions, self._velocities, self._control = data.qpos, data.qvel, data.ctrl if model.nu else np.zeros(1)
        self._bias, self._accelerations, self._applied = data.qfrc_bias, data.qacc_warmstart, data.qfrc_applied
        masses = model.body_subtreemass[model.body_rootid[model.jnt_bodyid[ids]]]
        self.inertias = model.dof_M0[dofs] + carries * masses
        self._implicit = self._step * (self._damping + self._step * self._stiffness) / self.inertias
        self._springs = bool(self._stiffness.any())
        indices = dofs, self._coordinates, self._position_servos, self._velocity_servos
        self._nothing = _NOTHING * self._most
        numbers = self._stiffness, self._damping, self._most, self._nothing, self.inertias, self._implicit
        self.table = np.rec.fromarrays([*indices, *numbers], dtype=LIMITED).view(np.ndarray)
        self.reach = 1.0 + self._implicit

    def start(self, prefix: str = "") -> None:
        """Assume that the joints whose names begin with a prefix move freely, because there is no last step to measure."""
        mine = np.array([joint.startswith(prefix) for joint in self.joints], np.bool_)
        self.reach = np.where(mine, 1.0 + self._implicit, self.reach)

    def carry_over(self, old: ForceLimits) -> None:
        """Copy the measured freedom of motion from the limits of another model, for each joint that both models have."""
        known = dict(zip(old.joints, old.reach.tolist(), strict=True))
        self.reach = np.array([known.get(joint, free) for joint, free in zip(self.joints, self.reach, strict=True)])

    def _forces(self, positions: Floats, velocities: Floats) -> Floats:
        """Return the force (N m or N) that each drive exerts at the given positions and velocities of the joints."""
        forces: Floats = self._damping * (self._control.take(self._velocity_servos) - velocities)
        if self._springs:
            forces += self._stiffness * (self._control.take(self._position_servos) - positions)
        return forces

    def observe(self) -> None:
        """Measure how freely each joint moved in the last step; call this before set points change and before `apply`.

        The measurement counts commanded efforts as forces of the drives.
        """
        dofs, implicit = self._dofs, self._implicit
        positions, velocities = self._positions.take(self._coordinates), self._velocities.take(dofs)
        bias = self._bias.take(dofs)
        self._state = positions, velocities, bias
        exerted = self._forces(positions, velocities) + self._applied.take(dofs)
        moved, left = self.inertias * self._accelerations.take(dofs), exerted - bias
        told = np.minimum(np.abs(exerted), np.abs(left)) > self._nothing
        freely = np.divide(moved, left, out=np.ones_like(left), where=told)
        if (turned := freely < 0.0).any():
            # Something else turned F round: G a against it is more than F, unless a stop holds the joint.
            freely[turned] = np.abs(implicit * moved)[turned] > np.abs(left)[turned]
        self.reach = np.minimum(1.0 + implicit * np.minimum(np.maximum(freely, 0.0), 1.0), 2.0 * self.reach)

    def apply(self, efforts: Floats, compensation: Floats | None = None) -> None:
        """Reduce the forces of drives that would exceed their maximum in the next step.

        Args:
            efforts: commanded efforts of all degrees of freedom, N m or N; they are not limited.
            compensation: efforts of gravity compensation, N m or N; they count as forces of the drives. None for no compensation.
        """
        positions, velocities, bias = self._state
        added = own = efforts.take(self._dofs)
        forces = self._forces(positions + self._step * velocities if self._springs else positions, velocities)
        if compensation is not None:
            carried = compensation.take(self._dofs)
            added = own + carried
            forces += carried
        middle, most = (self.reach - 1.0) * (own - bias), self._most * self.reach
        legal = np.minimum(np.maximum(forces, middle - most), middle + most)
        self._applied[self._dofs] = added - (forces - legal)


def tell_limits(limits: ForceLimits, robots: Mapping[str, RobotInstance], findings: Findings) -> None:
    """Add a note for each joint whose robot file gives a maximum force; it states the acceleration that this force allows."""
    told: set[tuple[int, str]] = set()
    for name, inertia in zip(limits.joints, limits.inertias.tolist(), strict=True):
        owner, _, joint = name.partition("/")
        robot = robots[owner]
        spec = robot.spec.joints[joint]
        key, drive = ("drive", spec.drive) if spec.drive is not None else ("usd_drive", spec.usd_drive)
        if (id(robot.file), joint) in told or drive is None or drive.max_force is None:
            continue
        told.add((id(robot.file), joint))
        sliding = robot.description.joints[joint].type == "prismatic"
        force, mass, slope = ("N", "kg", "m/s2") if sliding else ("N m", "kg m2", "rad/s2")
        most = drive.max_force
        text = (
            f"max_force {most:g} {force} accelerates the inertia of {inertia:.3g} {mass} "
            f"by at most {most / inertia:.3g} {slope}"
        )
        findings.add("N103", f"joint {joint!r}: {text}", robot.file.key_span("joints", joint, key))
