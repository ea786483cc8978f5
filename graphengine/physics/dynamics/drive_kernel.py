"""The kernel that prepares the drives of all robots for a physics step; importing this module requires numba.

The kernel does the work of `SetPoints.take_over`, `GravityCompensation.apply` and `ForceLimits`, whose docstrings explain it. Its
results equal theirs bit by bit, except for the sign of zeros.
"""

from __future__ import annotations

from typing import Any

from graphengine.descriptions.engine import Bools, Floats
from graphengine.physics.kernels.compiled import kernel, part


@kernel
def prepare_drives(
    pending: bool,
    steps: int,
    targets: Floats,
    efforts: Floats,
    reach: Floats,
    changes: Floats,
    even: Bools,
    limited: Any,
    carrying: Any,
    step: float,
    positions: Floats,
    velocities: Floats,
    bias: Floats,
    accelerations: Floats,
    masses: Floats,
    centres: Floats,
    axes: Floats,
    anchors: Floats,
    gravity: Floats,
    compensation: Floats,
    control: Floats,
    applied: Floats,
) -> bool:
    """Estimate loads, advance set points, compensate gravity and limit forces; return whether set points still change.

    Args:
        pending: whether set points or efforts change in this step.
        steps: number of steps left in the tick.
        targets: target of each actuator.
        efforts: commanded effort of each degree of freedom, N m or N.
        reach: 1 + s G / I of each limited drive; updated.
        changes: maximum change of each actuator's set point in a step.
        even: whether each actuator spreads its change evenly over the tick.
        limited: table of the drives with a maximum force, `force_limits.LIMITED`.
        carrying: table of the drives that compensate for gravity, `gravity_compensation.CARRYING`.
        step: length of a step, s.
        positions: `qpos` of the state.
        velocities: `qvel`.
        bias: `qfrc_bias`.
        accelerations: `qacc_warmstart`.
        masses: mass of each body on which gravity acts, kg.
        centres: `xipos`.
        axes: `xaxis`.
        anchors: `xanchor`.
        gravity: acceleration of free fall along the axes of the world, m/s2; x and y are 0.
        compensation: compensating effort of each degree of freedom; updated.
        control: `ctrl`; updated.
        applied: `qfrc_applied`; updated.
    """
    for row in range(len(limited)):
        drive = limited[row]
        dof, implicit = drive.dof, drive.implicit
        exerted = _force(drive, control, positions[drive.coordinate], velocities[dof]) + applied[dof]
        moved, left, freely = drive.inertia * accelerations[dof], exerted - bias[dof], 1.0
        if min(abs(exerted), abs(left)) > drive.nothing:
            freely = moved / left
        if freely < 0.0:
            freely = 1.0 if abs(implicit * moved) > abs(left) else 0.0
        reach[row] = min(1.0 + implicit * min(max(freely, 0.0), 1.0), 2.0 * reach[row])
    if pending:
        pending = False
        for actuator in range(len(targets)):
            target, most = targets[actuator], changes[actuator]
            if even[actuator] and steps > 1:
                most = min(most, abs(target - control[actuator]) / steps)
            control[actuator] = min(max(target, control[actuator] - most), control[actuator] + most)
            pending = pending or control[actuator] != target
        for dof in range(len(efforts)):
            applied[dof] = efforts[dof]
    for row in range(len(carrying)):
        own = _weight(carrying[row], masses, centres, axes, anchors, gravity[2])
        compensation[carrying[row].dof] = own
        applied[carrying[row].dof] = efforts[carrying[row].dof] + own
    for row in range(len(limited)):
        drive = limited[row]
        dof = drive.dof
        own, added = efforts[dof], efforts[dof] + compensation[dof]
        ahead = positions[drive.coordinate] + step * velocities[dof]
        force = _force(drive, control, ahead, velocities[dof]) + compensation[dof]
        middle, most = (reach[row] - 1.0) * (own - bias[dof]), drive.most * reach[row]
        applied[dof] = added - (force - min(max(force, middle - most), middle + most))
    return pending


@part
def _force(drive: Any, control: Floats, position: float, velocity: float) -> Any:
    """Return the force (N m or N) that a drive exerts at a position and a velocity of its joint."""
    force = 0.0
    if drive.stiffness != 0.0:
        force = drive.stiffness * (control[drive.position_servo] - position)
    if drive.damping != 0.0:
        force += drive.damping * (control[drive.velocity_servo] - velocity)
    return force


@part
def _weight(drive: Any, masses: Floats, centres: Floats, axes: Floats, anchors: Floats, gravity: float) -> Any:
    """Return the effort (N m or N) with which a drive holds the links beyond its joint at rest."""
    axis, anchor, carried = axes[drive.joint], anchors[drive.joint], drive.carried
    if drive.slides:
        return -(carried * (gravity * axis[2]))
    first, rest = drive.body, drive.bodies - 1
    x, y = masses[first] * centres[first, 0], masses[first] * centres[first, 1]
    if rest:
        x += add_moments(masses, centres, 0, first + 1, rest)
        y += add_moments(masses, centres, 1, first + 1, rest)
    x, y = x - carried * anchor[0], y - carried * anchor[1]
    return -(y * (gravity * axis[0]) - x * (gravity * axis[1]))


@part
def add_moments(masses: Floats, centres: Floats, axis: int, first: int, count: int) -> Any:
    """Return the sum of mass times coordinate along an axis over some bodies, added pairwise in the order of numpy's sums."""
    if count < 8:
        total = 0.0
        for body in range(first, first + count):
            total += masses[body] * centres[body, axis]
        return total
    if count > 128:
        half = count // 2 - count // 2 % 8
        rest = add_moments(masses, centres, axis, first + half, count - half)
        return add_moments(masses, centres, axis, first, half) + rest
    lane, whole = _add_lane, first + count // 8 * 8
    total = lane(masses, centres, axis, first, whole) + lane(masses, centres, axis, first + 1, whole)
    total += lane(masses, centres, axis, first + 2, whole) + lane(masses, centres, axis, first + 3, whole)
    other = lane(masses, centres, axis, first + 4, whole) + lane(masses, centres, axis, first + 5, whole)
    other += lane(masses, centres, axis, first + 6, whole) + lane(masses, centres, axis, first + 7, whole)
    total += other
    for body in range(whole, first + count):
        total += masses[body] * centres[body, axis]
    return total


@part
def _add_lane(masses: Floats, centres: Floats, axis: int, first: int, end: int) -> Any:
    """Return the sum of mass times coordinate over every eighth body."""
    total = 0.0
    for body in range(first, end, 8):
        total += masses[body] * centres[body, axis]
    return total
