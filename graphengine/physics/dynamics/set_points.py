"""Keeps the commanded targets of drives and efforts of joints, and moves set points towards the targets within rate limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.actuators.drives import Drive, servo_ids
from graphengine.descriptions.engine import mujoco
from graphengine.format.stateful import Stateful


class SetPoints(Stateful):
    """The commanded targets of actuators and efforts of joints; they take effect at the beginning of the next step.

    Args:
        model: compiled model; its timestep is the step.
        data: state of the simulation.
        drives: drives by the names of their joints in the model.

    Attributes:
        targets: target of each actuator of the model, in its own unit.
        efforts: effort of each degree of freedom, N m or N.
        changes: maximum change of each actuator's set point in a step.
        even: whether each actuator spreads its change evenly over a tick.
        pending: whether the next step has to apply changes.
    """

    kept = ("efforts", "pending", "targets")
    __slots__ = ("_applied", "_control", "_rests", "_starts", "changes", "efforts", "even", "pending", "targets")

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Sequence[tuple[str, Drive]]) -> None:
        self._control, self._applied = data.ctrl, data.qfrc_applied
        self.changes = np.full(model.nu, np.inf)
        self._starts: dict[int, float] = {}
        self.even = np.zeros(model.nu, np.bool_)
        self._rests: dict[int, float] = {}
        """A dict from actuator id to the control signal for zero velocity or zero effort."""
        for (joint, drive), (position, velocity, _) in zip(drives, servo_ids(model, drives).T.tolist(), strict=True):
            if drive.servos is not None:
                self._rests |= _at_rest(model, joint, drive)
                continue
            if position >= 0:
                self.changes[position] = drive.max_velocity * model.opt.timestep
            if velocity >= 0:
                self.changes[velocity] = drive.max_acceleration * model.opt.timestep
                self._starts[velocity], self._rests[velocity] = drive.target_velocity, 0.0
            if drive.interpolate:
                self.even[[servo for servo in (position, velocity) if servo >= 0]] = True
        self.targets, self.efforts = np.zeros(model.nu), np.zeros(model.nv)
        self.start()

    def start(self) -> None:
        """Set the initial commands: target velocities of drives, current control signals of other actuators, and no effort."""
        self.targets[:] = self._control
        for servo, velocity in self._starts.items():
            self.targets[servo] = velocity
        self.efforts[:] = 0.0
        self.pending = True

    def zero(self) -> None:
        """Command all joints to stop: set velocity targets and efforts to zero, and keep position targets."""
        for servo, control in self._rests.items():
            self.targets[servo] = control
        self.efforts[:] = 0.0
        self.pending = True

    def take_over(self, steps: int) -> None:
        """Move the set points towards their targets within their rate limits, and apply the commanded efforts.

        Args:
            steps: number of steps left in the tick; a drive that interpolates spreads its change evenly over them.
        """
        if self.pending:
            control, changes = self._control, self.changes
            if steps > 1 and self.even.any():
                ways = np.abs(self.targets - control) / steps
                changes = np.minimum(changes, ways, out=changes.copy(), where=self.even)
            np.minimum(np.maximum(self.targets, control - changes), control + changes, out=control)
            self._applied[:] = self.efforts
            self.pending = bool((control != self.targets).any())


def _at_rest(model: mujoco.MjModel, joint: str, drive: Drive) -> dict[int, float]:
    """Return a dict from the id of each velocity and effort actuator of a drive to the control signal that commands zero."""
    found = [drive.servo(joint, kind) for kind in ("velocity", "effort")]
    return {model.actuator(servo.name).id: servo.control(0.0) for servo in found if servo is not None}
