"""The layer of trails: the paths that robots have driven; the page's process stores them."""

from __future__ import annotations

import time
from collections import deque
from typing import Any

import numpy as np

from graphengine.view.layer_data import FrameLayers, SceneLayers
from graphengine.view.scene.carried import Carried, Floats
from graphengine.view.scene.layer import Layer, Poses

STEP = 0.05
"""Minimum distance between two points of a trail, m."""
MOST_POINTS = 1000
"""Maximum number of points of a trail; older points are discarded."""
JUMP = 1.0
"""Distance from the last point of a trail beyond which the trail restarts, m: a command must have moved the robot."""
PERIOD = 0.25
"""Minimum wall time between two updates of the drawn trails, s."""
LIFT = 0.03
"""Height of trails above the origins of robots, m."""
COLOURS = ((31, 119, 180), (255, 127, 14), (44, 160, 44), (214, 39, 40), (148, 103, 189), (23, 190, 207))


class RobotTrails(Layer):
    """A line along the path of each robot."""

    name = "trails"
    title = "Trails"
    hint = "Paths that robots have driven"

    def _draw(self, layers: SceneLayers) -> None:
        robots = [entity.mount for entity in layers.entities if entity.robot]
        self._carried = Carried.of([(mount.body, mount.pose) for mount in robots])
        self._trails: list[deque[Floats]] = [deque(maxlen=MOST_POINTS) for _ in robots]
        self._grown: set[int] = set()
        self._next = 0.0
        self._lines: list[Any] = [
            self._scene.add_line_segments(
                f"{self.path}/{row}",
                np.zeros((1, 2, 3), np.float32),
                COLOURS[row % len(COLOURS)],
                thickness=0.025,
                visible=False,
            )
            for row in range(len(robots))
        ]

    def _update(self, poses: Poses, frame: FrameLayers) -> None:
        """Store the positions of robots, and draw the trails that have grown, once per `PERIOD`."""
        if not self._trails:
            return
        positions, _ = self._carried.at(poses)
        for row, (trail, position) in enumerate(zip(self._trails, positions, strict=True)):
            way = float(np.linalg.norm(position - trail[-1])) if trail else STEP
            if way > JUMP:
                trail.clear()
            if way >= STEP:
                trail.append(position)
                self._grown.add(row)
        now = time.monotonic()
        if self.shown and self._grown and now >= self._next:
            self._next = now + PERIOD
            for row in self._grown:
                self._show(row)
            self._grown.clear()

    def _show(self, row: int) -> None:
        points, line = np.array(self._trails[row]), self._lines[row]
        line.visible = len(points) > 1
        if len(points) > 1:
            points[:, 2] += LIFT
            line.points = np.stack([points[:-1], points[1:]], axis=1)
