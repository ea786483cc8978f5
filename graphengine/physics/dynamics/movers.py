"""Movers: bodies that follow their routes regardless of obstacles, and push or carry the bodies that they touch.

As for moving surfaces, contacts hardly change the velocity of a mover's joints, because their inertia is large. MuJoCo integrates
this velocity from step to step. Position and velocity are set to those of the route when a mover turns, and after each tick in
which a contact has changed the velocity. So they depend only on the route, except for rounding and within such a tick.
"""

from __future__ import annotations

import copy
import math
from array import array
from collections.abc import Set
from typing import Self

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.routes import route_from, routes_of
from graphengine.physics.dynamics.free_points import motion_of
from graphengine.physics.dynamics.mover_motion import Coordinates, MoverMotion, Piece


class Movers:
    """The movers of a compiled model; `bound_to` looks them up.

    Attributes:
        walking: whether movers move; while a scene settles, they stand where they start.
        due: number of steps after which `follow` is to be called next: at the end of each tick, and when a mover turns.

    Args:
        tick: duration of a tick in seconds as a fraction: numerator and denominator.
        substeps: physics steps in a tick.
    """

    def __init__(self, tick: tuple[int, int], substeps: int) -> None:
        self.walking = True
        self.due = math.inf
        self._seconds, self._steps, self._substeps = tick[0], tick[1] * substeps, substeps
        self._seed, self._end = 0, 0.0
        """Seed of the present motion, and number of steps after which it ends."""
        self._motions: dict[str, tuple[str, MoverMotion]] = {}
        """Text of the route of each mover, and its motion."""
        self._pieces: list[Piece] = []
        self._origins: list[tuple[Coordinates, slice]] = []
        """Position of each mover at which its joints have the coordinate 0, and the range of its joints in the arrays below."""
        self._positions = np.empty(0)
        self._velocities = self._expected = memoryview(array("d"))
        """Velocities of all joints in the state, and on the route."""

    @property
    def names(self) -> Set[str]:
        """Names of the movers' bodies, in order of the model."""
        return self._motions.keys()

    def stuck(self) -> set[str]:
        """Return the names of the movers that cannot walk at random.

        A mover stands still if no obstacle-free straight path connects two free points of its region.
        """
        return {name for name, (_, motion) in self._motions.items() if motion.stuck}

    def __bool__(self) -> bool:
        return bool(self._motions)

    def bound_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """Return the movers of another model; movers with the same routes keep their motion."""
        made, count = copy.copy(self), 0
        made._motions, made._origins = {}, []
        for name, text in routes_of(model).items():
            known, body = self._motions.get(name), model.body(name)
            if known is None or known[0] != text:
                known = text, motion_of(model, name, route_from(text))
            made._motions[name] = known
            x, y, z = body.pos.tolist()
            made._origins.append(((x, y, 0.0, z), slice(count, count + int(body.jntnum[0]))))
            count += int(body.jntnum[0])
        if made._motions:
            first = model.body(next(iter(made._motions)))
            place, dof = int(model.joint(first.jntadr[0]).qposadr[0]), int(first.dofadr[0])
            made._positions = data.qpos[place : place + count]
            made._velocities = memoryview(data.qvel[dof : dof + count])  # NumPy takes longer to compare few numbers
        return made

    def hold(self, steps: int, seed: int, *, only_changed: bool = False) -> None:
        """Write the positions and velocities of movers after a number of physics steps to the state.

        Args:
            steps: number of steps.
            seed: seed of the session.
            only_changed: whether to write only the movers that turn, and those whose velocity a contact has changed.
        """
        before, expected = self._pieces, self._expected
        time = self.schedule(steps, seed)
        for number, (piece, (origin, joints)) in enumerate(zip(self._pieces, self._origins, strict=True)):
            if only_changed and piece is before[number] and self._velocities[joints] == expected[joints]:
                continue
            since = time - piece.begin
            places = zip(piece.at, piece.velocity, origin, strict=True)
            self._positions[joints] = [at + speed * since - start for at, speed, start in places][
                : joints.stop - joints.start
            ]
        self._velocities[:] = self._expected

    def follow(self, steps: int, seed: int) -> None:
        """Call `hold` if a mover turns after a number of physics steps, or if a contact has changed a velocity."""
        if steps >= self._end or seed != self._seed or self._velocities.tobytes() != self._expected.tobytes():
            self.hold(steps, seed, only_changed=True)
        else:
            self._set_due(steps)

    def schedule(self, steps: int, seed: int) -> float:
        """Look up how all movers move after a number of physics steps; return the time of this state, s."""
        time = steps * self._seconds / self._steps if self.walking else 0.0
        self._pieces, self._seed = [motion.at(time, seed) for _, motion in self._motions.values()], seed
        speeds = [
            speed if self.walking else 0.0
            for piece, (_, joints) in zip(self._pieces, self._origins, strict=True)
            for speed in piece.velocity[: joints.stop - joints.start]
        ]
        self._expected = memoryview(array("d", speeds))
        self._end = min((piece.end for piece in self._pieces), default=math.inf) * self._steps / self._seconds
        self._set_due(steps)
        return time

    def _set_due(self, steps: int) -> None:
        end_of_tick = steps - steps % self._substeps + self._substeps
        self.due = min(end_of_tick, max(steps + 1, self._end)) if self._motions else math.inf
