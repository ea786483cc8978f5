"""Movers: bodies that follow their routes regardless of obstacles, and push or carry the bodies that they touch.

As for moving surfaces, contacts hardly change the velocity of a mover's joints, because their inertia is large. MuJoCo integrates
this velocity from step to step. Position and velocity are set to those of the route when a mover turns, and at all multiples of
`CORRECTED_AFTER`; in this time, a force of 1 kN changes the position by 0.13 mm. A mover that rises carries loads. So where one
does, all movers are corrected after each tick.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Set
from typing import Self

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.routes import route_from, routes_of
from graphengine.physics.dynamics.free_points import motion_of
from graphengine.physics.dynamics.mover_motion import Coordinates, MoverMotion, Piece
from graphengine.physics.model.surface_joints import FLAT

CORRECTED_AFTER = 0.5
"""Time between two corrections of all movers, rounded down to whole ticks, s."""


class Movers:
    """The movers of a compiled model; `bound_to` looks them up.

    Attributes:
        walking: whether movers move; while a scene settles, they stand where they start.
        due: number of steps after which `hold` is to be called next.

    Args:
        tick: duration of a tick in seconds as a fraction: numerator and denominator.
        substeps: physics steps in a tick.
    """

    def __init__(self, tick: tuple[int, int], substeps: int) -> None:
        self.walking = True
        self.due = math.inf
        self._seconds, self._steps = tick[0], tick[1] * substeps
        self._substeps, self._ticks = substeps, max(1, int(CORRECTED_AFTER * tick[1] / tick[0]))
        self._interval = substeps
        """Number of steps between two corrections."""
        self._motions: dict[str, tuple[str, MoverMotion]] = {}
        """Text of the route of each mover, and its motion."""
        self._origins: list[tuple[Coordinates, int]] = []
        """Position of each mover at which its joints have the coordinate 0, and the number of its joints."""
        self._positions = self._velocities = np.empty(0)

    @property
    def names(self) -> Set[str]:
        """Names of the movers' bodies, in order of the model."""
        return self._motions.keys()

    def stuck(self) -> set[str]:
        """Return the names of the movers whose region has no straight ways between free points."""
        return {name for name, (_, motion) in self._motions.items() if motion.stuck}

    def __bool__(self) -> bool:
        return bool(self._motions)

    def bound_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """Return the movers of another model; movers with the same routes keep their motion."""
        made = copy.copy(self)
        made._motions, made._origins = {}, []
        for name, text in routes_of(model).items():
            known, body = self._motions.get(name), model.body(name)
            made._motions[name] = (
                known if known and known[0] == text else (text, motion_of(model, name, route_from(text)))
            )
            x, y, z = body.pos.tolist()
            made._origins.append(((x, y, 0.0, z), int(body.jntnum[0])))
        if made._motions:
            sizes = [size for _, size in made._origins]
            made._interval = self._substeps * (1 if max(sizes) > len(FLAT) else self._ticks)
            first, count = model.body(next(iter(made._motions))), sum(sizes)
            place, dof = int(model.joint(first.jntadr[0]).qposadr[0]), int(first.dofadr[0])
            made._positions, made._velocities = data.qpos[place : place + count], data.qvel[dof : dof + count]
        return made

    def hold(self, steps: int, seed: int) -> None:
        """Write the positions and velocities of all movers after a number of physics steps to the state."""
        time, pieces = self.schedule(steps, seed)
        joints = [
            (place - start + speed * (time - piece.begin), speed)
            for piece, (origin, size) in zip(pieces, self._origins, strict=True)
            for place, speed, start in list(zip(piece.at, piece.velocity, origin, strict=True))[:size]
        ]
        self._positions[:] = [place for place, _ in joints]
        self._velocities[:] = [speed for _, speed in joints] if self.walking else 0.0

    def schedule(self, steps: int, seed: int) -> tuple[float, list[Piece]]:
        """Set `due` for the state after a number of steps; return the time of this state (s) and how all movers move then."""
        time = steps * self._seconds / self._steps if self.walking else 0.0
        pieces = [motion.at(time, seed) for _, motion in self._motions.values()]
        end = min((piece.end for piece in pieces), default=math.inf) * self._steps / self._seconds
        self.due = min(steps - steps % self._interval + self._interval, max(steps + 1, end)) if pieces else math.inf
        return time, pieces
