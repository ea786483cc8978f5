"""A drive of the scene `demo`: what the robot touches, and which places it passes."""

from __future__ import annotations

import math
import random

import numpy as np

import graphengine as ge
from graphengine.api.pictures import simulated

ROUND = {
    "the wide aisle": ((-7.5, -3.0), (3.0, 9.0)),
    "the cross aisle": ((-9.0, -7.0), (12.6, 16.0)),
    "the narrow aisle": ((-11.4, -8.6), (2.0, 8.0)),
    "the south end of the rack": ((-9.0, -7.0), (-7.0, -4.1)),
}
"""Places around a rack in the order of a round: ranges of x and of y, m."""
ROBOT = "dd100"


class Drive:
    """A running session of the scene, judged after each tick.

    Attributes:
        contacts: names of the bodies that the robot touched, other than the floor.
        passed: number of places passed in the order of the round.
        length: of the path, m.
    """

    def __init__(self, sim: ge.Session, seed: int = 0) -> None:
        self.sim = sim
        self.contacts: set[str] = set()
        self.passed = 0
        self.length = 0.0
        chance = random.Random(seed)
        x, y, yaw = (
            -6.4 + chance.uniform(-0.5, 0.5),
            6.0 + chance.uniform(-1, 1),
            math.pi / 2 + chance.uniform(-0.5, 0.5),
        )
        sim.move(ROBOT, (x, y), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
        self._world = simulated(sim._runner.session.services.world)
        model = self._world.model
        self._names = [model.body(body).name or "the floor" for body in model.geom_bodyid]
        own = [model.body(model.body_rootid[body]).name.startswith(ROBOT) for body in model.geom_bodyid]
        self._own, self._floor = (
            np.array(own),
            np.array([model.geom(geom).name == "floor" for geom in range(model.ngeom)]),
        )
        self._place = self.place

    @property
    def place(self) -> tuple[float, float]:
        """Where the robot is, m."""
        x, y, _ = self.sim.robots[ROBOT].pose.position
        return x, y

    @property
    def rounds(self) -> int:
        """Rounds that ended where they began."""
        return max(0, self.passed - 1) // len(ROUND)

    def run(self, seconds: float) -> None:
        """Drive on."""
        self.sim.run(seconds, until=self._look)

    def _look(self, _: ge.Session) -> bool:
        touching = self._world.data.contact.geom
        own, floor = self._own[touching], self._floor[touching]
        for pair in touching[(own[:, 0] != own[:, 1]) & ~floor.any(axis=1)].tolist():
            self.contacts |= {self._names[geom] for geom in pair if not self._own[geom]}
        before, self._place = self._place, self.place
        self.length += math.dist(before, self._place)
        (west, east), (south, north) = list(ROUND.values())[self.passed % len(ROUND)]
        self.passed += west < self._place[0] < east and south < self._place[1] < north
        return False
