"""A camera that keeps robots in its image, and moves with them smoothly in simulation time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from graphengine.descriptions.engine import Floats
from graphengine.devices.rotation import Pose
from graphengine.devices.stage import Prim
from graphengine.physics.views import framing

if TYPE_CHECKING:
    from graphengine.physics.simulation import Simulation

FILLED = 0.31
"""Share of the image's height that a followed robot fills; a wide robot fills `WIDE` of the width instead, and is then lower."""
WIDE = 0.5
LOWER = 0.16
"""Distance of a followed robot below the middle of the image, divided by the image's height. It leaves room for the robot's way
ahead."""
ONE, MANY = 0.42, 0.85
"""Share of the image's height and width that one robot, or several, fill in the perspective view."""
BEHIND = tuple(math.radians(degrees) for degrees in (17.0, 32.0, 47.0, 62.0))
"""Angles between the line of sight of a camera that follows a robot and the floor; the first one without an obstacle is taken."""
TURNING, RAISING, MOVING, RESIZING, RETURNING = 0.6, 0.4, 0.25, 1.0, 1.5
"""Time constants with which a camera turns, rises, follows position and size of a robot, and moves back after an obstacle, s."""
GAP = 0.95
"""Distance of a camera from the robot before an obstacle, divided by the length of the free way."""
NEAREST = 0.2
"""Share of its distance from a robot that a camera keeps even if an obstacle is closer."""


class RobotCamera:
    """Follows the first robot from behind and above, or shows all robots from one direction.

    A robot that is fixed to the world has no way to follow; it is shown from the best direction too.

    Args:
        simulation: world with the robots; in a world without robots, the camera shows everything.
        halves: half the width and half the height of the image at a distance of 1 m, m.
        follows: whether the camera follows the first robot.
    """

    def __init__(self, simulation: Simulation, halves: tuple[float, float], *, follows: bool) -> None:
        self._simulation = simulation
        self._follows = follows
        self._wide, self._high = halves
        self._back: Floats | None = None
        """Direction from the robots to a camera that does not turn; None until it is chosen."""
        self._time: float | None = None
        self._azimuth, self._elevation, self._free = 0.0, BEHIND[0], 1.0
        self._centre = self._offset = np.zeros(3)

    def aim(self, time: float) -> tuple[Pose, Floats, float]:
        """Return the camera's pose, the centre of the visible robots, and the distance of the camera from this centre, m.

        Args:
            time: time of the image, s; the camera moves in the time since the last call, and the first call places it.
        """
        elapsed = math.inf if self._time is None else max(time - self._time, 0.0)
        self._time = time
        robots = list(self._simulation.stage.prims("robot"))
        robots = robots[:1] if self._follows else robots
        points = [framing.robot_points(self._simulation, robot) for robot in robots]
        shown = np.concatenate(points or [framing.world_points(self._simulation)])
        self._centre = _approach(self._centre, framing.middle(shown), elapsed, MOVING)
        behind = self._follows and bool(robots) and self._moves(robots[0])
        back = self._behind(robots[0], shown, elapsed) if behind else self._beside(robots)
        self._offset = _approach(self._offset, self._best_offset(shown, back, len(robots)), elapsed, RESIZING)
        way = self._offset @ framing.camera_axes(back)
        if behind:
            way *= self._unblocked(robots[0], way, elapsed)
        return framing.camera_pose(self._centre + way, back), self._centre, float(np.linalg.norm(way))

    def _part(self, robots: int) -> tuple[float, float]:
        """Return half the width and half the height of the part of the image that the robots should fill."""
        if self._follows and robots:
            return self._wide * WIDE, self._high * FILLED
        filled = ONE if robots == 1 else MANY
        return self._wide * filled, self._high * filled

    def _moves(self, robot: Prim) -> bool:
        model = self._simulation.model
        return any(model.body_dofnum[root] > 0 for root in self._simulation.entities.roots(robot))

    def _best_offset(self, shown: Floats, back: Floats, robots: int) -> Floats:
        """Return where the camera should be relative to the centre of some points, along its own axes, m."""
        offset = framing.fitting_offset(shown, framing.middle(shown), back, self._part(robots))
        if self._follows and robots:
            offset[1] += 2 * LOWER * self._high * offset[2]
        return offset

    def _behind(self, robot: Prim, shown: Floats, elapsed: float) -> Floats:
        """Return the direction from a robot to the camera behind it. The camera rises if a body hides the robot."""
        turn = math.remainder(framing.heading(self._simulation, robot) + math.pi - self._azimuth, math.tau)
        self._azimuth += turn * _share(elapsed, TURNING)
        best, most = BEHIND[0], 0.0
        for elevation in BEHIND:
            back = framing.direction(self._azimuth, elevation)
            way = self._best_offset(shown, back, 1) @ framing.camera_axes(back)
            free = framing.free_share(self._simulation, robot, self._centre, self._centre + way)
            if free > most:
                best, most = elevation, free
            if most == 1.0:
                break
        self._elevation += (best - self._elevation) * _share(elapsed, RAISING)
        return framing.direction(self._azimuth, self._elevation)

    def _beside(self, robots: list[Prim]) -> Floats:
        if self._back is None:
            self._back = framing.best_direction(self._simulation, robots, self._part(len(robots)))
        return self._back

    def _unblocked(self, robot: Prim, way: Floats, elapsed: float) -> float:
        """Return the share of the way to the camera that it may keep; it comes closer at once, and moves back slowly."""
        free = framing.free_share(self._simulation, robot, self._centre, self._centre + way)
        free = max(GAP * free, NEAREST) if free < 1.0 else 1.0
        self._free = min(free, self._free + (free - self._free) * _share(elapsed, RETURNING))
        return self._free


def _share(elapsed: float, constant: float) -> float:
    return 1.0 - math.exp(-elapsed / constant)


def _approach(value: Floats, goal: Floats, elapsed: float, constant: float) -> Floats:
    return value + (goal - value) * _share(elapsed, constant)
