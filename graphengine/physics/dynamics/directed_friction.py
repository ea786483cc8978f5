"""Friction that differs in two directions, for mecanum wheels, omni wheels and skidding tyres.

MuJoCo has two friction coefficients per contact, along two tangents that it chooses itself. So this module acts after `mj_step1`
has found the contacts. It turns the tangents of a wheel's contacts to the direction that the wheel's material gives, and computes
the contact constraints again. Simulating each roller as a body would be less exact (errors of 1 % instead of 0.1 %) and take ten
times as long.

For materials with `steady_sliding`, it also corrects the load of sliding contacts. MuJoCo's contacts obey an associated law: a
contact with the friction coefficient f that slides at v is pushed apart as if it penetrated at f v. Skid-steered wheels therefore
hop, and touch the floor a tenth of the time. Subtracting f v from the normal velocity gives Coulomb's law (De Saxcé).
This is done by a shift of the penetration that the solver reads, because it recomputes the velocities.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from graphengine.descriptions.engine import collides, mujoco
from graphengine.devices.rotation import Vector3, rotate
from graphengine.devices.stage import Stage
from graphengine.physics.kernels.optional_kernels import load_kernel

_LEAST_FRICTION = 1e-5
"""The smallest friction coefficient that MuJoCo uses."""


class DirectedFriction:
    """Applies two friction coefficients to geoms whose friction differs along and across a direction.

    If two such geoms touch each other, the contact keeps MuJoCo's combined friction, which is equal in all directions.

    Args:
        stage: stage with material prims; the fact `frames` of a material names the bodies to which it is bound.
        model: compiled model.
        data: state of the simulation.

    Attributes:
        geoms: number of geoms in the model whose friction depends on the direction.
    """

    def __init__(self, stage: Stage, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        found = list(_directed_geoms(stage, model))
        self.geoms = len(found)
        if not found:
            return
        geoms, bodies, directions, ratios, steady = zip(*found, strict=True)
        self._model, self._data, self._rotations = model, data, data.xmat
        self._row_of = np.full(model.ngeom, -1)
        self._row_of[list(geoms)] = range(len(found))
        self._bodies, self._directions, self._ratios = np.array(bodies), np.array(directions), np.array(ratios)
        self._turn, self._load = _compiled()
        self._roots = np.where(steady, model.body_rootid[model.geom_bodyid[list(geoms)]], -1)
        self._keeps = any(steady) and model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC

    def apply(self) -> None:
        """Turn the tangents of the contacts that `mj_step1` found, and compute the contact constraints again."""
        if not self.geoms:
            return
        model, data, contact = self._model, self._data, self._data.contact
        table = self._row_of, self._bodies, self._directions, self._ratios
        if self._turn(contact.geom, contact.frame, contact.friction, self._rotations, *table):
            mujoco.mj_makeConstraint(model, data)
            mujoco.mj_projectConstraint(model, data)
            mujoco.mj_fwdVelocity(model, data)
            if self._keeps:
                self._keep_loads()

    def _keep_loads(self) -> None:
        """Shift the penetrations of sliding contacts so that sliding does not change their normal forces."""
        model, data, contact = self._model, self._data, self._data.contact
        velocities = np.empty(data.nefc)
        mujoco.mj_mulJacVec(model, data, velocities, data.qvel)
        of_contacts = contact.frame, contact.dist, contact.friction, contact.solref, contact.solimp
        of_rows = data.cvel, velocities, data.efc_pos, self._row_of, self._roots
        self._load(contact.geom, contact.efc_address, *of_contacts, *of_rows, model.opt.timestep)


def _directed_geoms(stage: Stage, model: mujoco.MjModel) -> Iterator[tuple[int, int, Vector3, float, bool]]:
    """Yield (geom id, body id, direction, ratio, steady) for each geom with friction in two directions or steady sliding.

    The direction is a unit vector in the frame of the body. The ratio is the friction across the direction, divided by the
    friction along it; `steady` is `steady_sliding` of the material.
    """
    solid = collides(model)
    for prim in stage.prims("material"):
        along, across = prim.facts["dynamic_friction"], prim.facts["across"]
        steady = prim.facts["steady_sliding"]
        if across is None or (across == along and not steady):
            continue
        ratio = across / along if along else math.inf
        for name, frame in prim.facts["frames"].items():
            carrier, (_, turn) = stage.find(frame).carrier()
            body = int(model.body(carrier).id) if carrier is not None else 0
            direction = rotate(turn, _unit(prim.facts["direction"]))
            for geom in np.flatnonzero((model.geom_bodyid == model.body(name).id) & solid).tolist():
                yield geom, body, direction, ratio, steady


def _unit(vector: Vector3) -> Vector3:
    largest = max(map(abs, vector))
    x, y, z = (part / largest for part in vector)
    length = math.hypot(x, y, z)
    return x / length, y / length, z / length


def turn_contacts(
    geoms: Any, frames: Any, frictions: Any, rotations: Any, row_of: Any, bodies: Any, directions: Any, ratios: Any
) -> bool:
    """Turn contact tangents to the directions of geoms and set both frictions, in place; return whether one was turned.

    The direction of a geom is projected on the contact plane. The closer the direction is to the contact normal, the less the two
    frictions differ. For a wheel that runs straight into a wall, they are nearly equal.

    Args:
        geoms: ids of the two geoms of each contact.
        frames: normal and both tangents of each contact, in the world frame.
        frictions: friction coefficients of each contact that MuJoCo combined from both geoms; the first two act along the
            tangents.
        rotations: rotation matrix of each body in the world frame, row by row.
        row_of: row of each geom in `bodies`, `directions` and `ratios`; -1 for geoms without a direction.
        bodies: ids of the bodies in whose frames the directions are given.
        directions: unit vectors.
        ratios: friction across the direction, divided by the friction along it.
    """
    turned = False
    for contact in range(len(geoms)):
        one, other = row_of[geoms[contact, 0]], row_of[geoms[contact, 1]]
        if (one < 0) == (other < 0):
            continue
        row, frame = max(one, other), frames[contact]
        matrix, direction = rotations[bodies[row]], directions[row]
        u, v, w = direction[0], direction[1], direction[2]
        x = matrix[0] * u + matrix[1] * v + matrix[2] * w
        y = matrix[3] * u + matrix[4] * v + matrix[5] * w
        z = matrix[6] * u + matrix[7] * v + matrix[8] * w
        a, b, c = frame[0], frame[1], frame[2]
        upward = x * a + y * b + z * c
        x, y, z = x - upward * a, y - upward * b, z - upward * c
        flat = x * x + y * y + z * z  # square of the sine of the angle between direction and normal
        if flat < 1e-12:
            continue
        length = math.sqrt(flat)
        x, y, z = x / length, y / length, z / length
        p, q, r = b * z - c * y, c * x - a * z, a * y - b * x
        ratio = ratios[row]
        if ratio > 1.0:  # MuJoCo's solver works best where the first tangent has the greater friction
            ratio = 1.0 / ratio
            x, y, z, p, q, r = p, q, r, -x, -y, -z
        frame[3], frame[4], frame[5], frame[6], frame[7], frame[8] = x, y, z, p, q, r
        frictions[contact, 1] = max(frictions[contact, 0] * (1.0 + (ratio - 1.0) * flat), _LEAST_FRICTION)
        turned = True
    return turned


def keep_loads(
    geoms: Any,
    addresses: Any,
    frames: Any,
    depths: Any,
    frictions: Any,
    solref: Any,
    solimp: Any,
    bodies: Any,
    velocities: Any,
    positions: Any,
    row_of: Any,
    roots: Any,
    step: float,
) -> None:
    """Shift the positions of contacts by the distances at which MuJoCo would push the sliding colliders apart.

    MuJoCo's discrete integrator computes a reference acceleration k x + b v of the spring and damper of each contact at the end
    of the step, and limits k to 1 / step^2. The solver resists the difference of this and the acceleration of the colliders, for
    which that of the robot in a steady turn is taken. The shift multiplied by k equals this difference along the tangents,
    multiplied by the friction coefficients.

    Args:
        geoms: ids of the two geoms of each contact.
        addresses: row of each contact's normal in the constraints; its tangents follow. Negative: no constraint.
        frames: normal and both tangents of each contact, in the world frame.
        depths: distance of the colliders at each contact, m; negative where they penetrate.
        frictions: friction coefficients of each contact; the first two act along the tangents.
        solref: time constant (s) and damping ratio of each contact.
        solimp: impedance of each contact.
        bodies: angular (rad/s) and linear velocity (m/s) of each body's tree, in the world frame.
        velocities: velocity along each constraint, m/s.
        positions: position of each constraint, m; changed in place.
        row_of: row of each geom in `roots`; -1 for geoms without a direction.
        roots: id of the root body of the geom's robot; -1 if contacts of the geom do not keep their load.
        step: length of a step, s.
    """
    for contact in range(len(geoms)):
        one, other, first = row_of[geoms[contact, 0]], row_of[geoms[contact, 1]], addresses[contact]
        constant, ratio = solref[contact, 0], solref[contact, 1]
        if (one < 0) == (other < 0) or roots[max(one, other)] < 0 or first < 0 or constant <= 0.0 or ratio <= 0.0:
            continue
        least, most, width = solimp[contact, 0], solimp[contact, 1], solimp[contact, 2]
        damping = 2.0 / (most * constant)
        body, frame, sign = bodies[roots[max(one, other)]], frames[contact], 1.0 if other >= 0 else -1.0
        x = body[1] * body[5] - body[2] * body[4]
        y = body[2] * body[3] - body[0] * body[5]
        z = body[0] * body[4] - body[1] * body[3]
        b = damping / (1.0 + damping * step)
        along = sign * (frame[3] * x + frame[4] * y + frame[5] * z) + b * velocities[first + 1]
        across = sign * (frame[6] * x + frame[7] * y + frame[8] * z) + b * velocities[first + 2]
        along, across = frictions[contact, 0] * along, frictions[contact, 1] * across
        pushed, shift = math.sqrt(along * along + across * across), 0.0
        for _ in range(3):  # the impedance, on which the stiffness depends, is that at the shifted position
            share = min(abs(depths[contact] + shift) / width, 1.0) if shift else 1.0
            share = 2.0 * share * share if share < 0.5 else 1.0 - 2.0 * (1.0 - share) * (1.0 - share)
            stiffness = (least + share * (most - least)) / (most * constant * ratio) ** 2
            limited = min(stiffness, 1.0 / (step * step))
            normal = damping * math.sqrt(limited / stiffness)
            shift = pushed * (1.0 + normal * step + limited * step * step) / limited
        positions[first] += shift


@functools.cache
def _compiled() -> tuple[Callable[..., bool], Callable[..., None]]:
    """Return `turn_contacts` and `keep_loads` compiled by numba, or the Python functions if numba does not work.

    Both give the same results to the last bit; the Python functions take 5 us longer per contact.
    """
    return load_kernel(_load, "turning contacts") or (turn_contacts, keep_loads)


def _load() -> tuple[Callable[..., bool], Callable[..., None]]:
    from graphengine.physics.kernels.compiled import kernel

    turn, keep = kernel(turn_contacts), kernel(keep_loads)
    rows = np.full(1, -1)
    for count in (1, 2):  # MuJoCo's arrays of one contact are contiguous, those of more are not
        geoms, floats = np.zeros((count, 3), np.int32), np.zeros((count, 10))
        table = rows, np.zeros(1, np.intp), np.zeros((1, 3)), np.zeros(1)
        turn(geoms[:, :2], floats[:, :9], floats[:, :5], np.zeros((1, 9)), *table)
        of_contacts = floats[:, :9], floats[:, 0], floats[:, :5], floats[:, :2], floats[:, :5]
        keep(geoms[:, :2], geoms[:, 2], *of_contacts, np.zeros((1, 6)), np.zeros(1), np.zeros(1), rows, rows, 0.1)
    return turn, keep
