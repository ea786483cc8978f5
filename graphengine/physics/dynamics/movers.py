"""Movers: bodies that follow their routes regardless of obstacles, and push or carry the bodies that they touch.

As for moving surfaces, the joints of a mover have so large an inertia that no contact changes their velocity. After each tick,
position and velocity are set to those of the route at this time, so a mover adds no state to checkpoints. Steps within a tick
integrate the velocity; the result differs from the route only by rounding.
"""

from __future__ import annotations

import copy
import math
from array import array
from collections.abc import Set
from typing import Any, Self

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.routes import route_from, routes_of
from graphengine.physics.dynamics.free_points import motion_of
from graphengine.physics.dynamics.mover_motion import Coordinates, MoverMotion


class Movers:
    """The movers of a compiled model; `bound_to` looks them up.

    Attributes:
        walking: whether movers move; while a scene settles, they stand where they start.
        due: number of steps after which `hold` is to be called next: at the end of each tick, and when a mover turns.

    Args:
        tick: duration of a tick in seconds as a fraction: numerator and denominator.
        substeps: physics steps in a tick.
    """

    def __init__(self, tick: tuple[int, int], substeps: int) -> None:
        self.walking = True
        self.due = math.inf
        self._clock = tick[0], tick[1] * substeps, substeps
        self._motions: dict[str, tuple[str, MoverMotion]] = {}
        """Text of the route of each mover, and its motion."""
        self._positions = self._speeds = memoryview(array("d"))
        self._origins: list[tuple[Coordinates, int]] = []
        """Place of each mover at which its joints have the coordinate 0, and the number of its joints."""
        self._motion: list[tuple[int, float, float]] = []
        """Number of each joint with its coordinate at time 0 (extrapolated) and its velocity."""
        self._velocities = array("d")
        self._seed, self._begin, self._end = 0, math.inf, math.inf

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
        made, sizes = copy.copy(self), list[int]()
        made._motions, made._begin = {}, math.inf
        for name, text in routes_of(model).items():
            known = self._motions.get(name)
            if known is None or known[0] != text:
                known = text, motion_of(model, name, route_from(text))
            made._motions[name] = known
            sizes.append(int(model.body(name).jntnum[0]))
        if made._motions:
            first = model.body(next(iter(made._motions)))
            place, dof, count = int(model.joint(first.jntadr[0]).qposadr[0]), int(first.dofadr[0]), sum(sizes)
            made._positions = memoryview(data.qpos[place : place + count])  # a quarter of the time that NumPy takes
            made._speeds = memoryview(data.qvel[dof : dof + count])
            origins = [model.body(name).pos.tolist() for name in made._motions]
            made._origins = [((x, y, 0.0, z), size) for (x, y, z), size in zip(origins, sizes, strict=True)]
        return made

    def hold(self, steps: int, seed: int) -> None:
        """Write the positions and velocities of all movers after a number of physics steps to the state."""
        if not self._motions:
            self.due = math.inf
            return
        seconds, count, substeps = self._clock
        time = steps * seconds / count if self.walking else 0.0
        if not self._begin <= time < self._end or seed != self._seed:
            self._look_up(time, seed)
        positions: Any = self._positions
        for number, offset, speed in self._motion:
            positions[number] = offset + speed * time
        self._speeds[:] = self._velocities if self.walking else array("d", bytes(self._speeds.nbytes))
        self.due = min(steps - steps % substeps + substeps, max(steps + 1, self._end * count / seconds))

    def _look_up(self, time: float, seed: int) -> None:
        """Look up how all movers move at a time, s."""
        pieces, self._seed = [motion.at(time, seed) for _, motion in self._motions.values()], seed
        self._begin, self._end = max(piece.begin for piece in pieces), min(piece.end for piece in pieces)
        motion = [
            (place - start - speed * piece.begin, speed)
            for piece, (origin, size) in zip(pieces, self._origins, strict=True)
            for place, speed, start in list(zip(piece.at, piece.velocity, origin, strict=True))[:size]
        ]
        self._motion = [(number, *pair) for number, pair in enumerate(motion)]
        self._velocities = array("d", [speed for _, speed in motion])
