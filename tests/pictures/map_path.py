"""Draw the map of the hall that Nav2 gets from `graphrun map`, with the true path of a robot and its newest scan.

    python -m tests.pictures.map_path docs/pictures/map_path.png

Nav2 does not run here: the script itself drives the robot from point to point by its command topic. Path and scan are drawn
where the simulation has them, not where a localization would.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import graphengine as ge
from graphengine import bringup
from graphengine.api.pictures import write_png
from graphengine.physics.occupancy.occupancy_map import OCCUPIED, OccupancyMap

POINTS = ((-5.2, 8.5), (-5.4, 14.2), (-10.0, 14.3), (-10.0, -3.0), (-10.0, -7.5), (-4.5, -8.5))
"""Points on the floor to drive to, m."""
NEAR, SPEED, TURN = 0.5, 0.9, 1.6
"""Distance at which the next point is chosen, m; speed, m/s; turn rate for an error of 1 rad, rad/s."""
FREE, WALL, UNKNOWN = (246, 247, 249), (38, 44, 54), (205, 210, 216)
PATH, SCAN, ROBOT = (30, 110, 220), (226, 60, 50), (245, 165, 20)
Points = list[tuple[float, float]]


def draw(path: Path) -> None:
    """Write the picture."""
    scene = ge.load("dd100_hall", rays="mujoco")
    floor = bringup.occupancy_map(scene)
    with scene.session() as sim:
        driven = _drive(sim)
        (topic,) = (claim.topic for claim in scene.topics if claim.message_type.endswith("/LaserScan"))
        scan = sim.subscribe(topic, keep=1)
        sim.run(0.3)
        hits = _hits(scan.latest, sim.robots["dd100"].pose)
    write_png(_picture(floor, driven, hits), path)


def _drive(sim: ge.Session) -> Points:
    """Drive to all points; return the path, with a place each 0.1 s."""
    robot, driven = sim.robots["dd100"], Points()
    for x, y in POINTS:
        while math.dist(robot.pose.position[:2], (x, y)) > NEAR and sim.time < 120.0:
            here = robot.pose.position
            error = math.remainder(math.atan2(y - here[1], x - here[0]) - _yaw(robot.pose), math.tau)
            speed = SPEED * max(math.cos(error), 0.0)
            robot.publish("cmd_vel", {"linear": {"x": speed}, "angular": {"z": TURN * error}})
            sim.run(0.1)
            driven.append((here[0], here[1]))
    return driven


def _yaw(pose: ge.Pose) -> float:
    x, y, z, w = pose.orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _hits(scan: Any, pose: ge.Pose) -> Points:
    """Return the points in the world that a LaserScan hit; the lidar is above the middle of the robot."""
    ranges = np.array(scan.ranges, float)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges)) + _yaw(pose)
    seen = np.isfinite(ranges)
    x, y = pose.position[0] + ranges * np.cos(angles), pose.position[1] + ranges * np.sin(angles)
    return list(zip(x[seen].tolist(), y[seen].tolist(), strict=True))


def _picture(floor: OccupancyMap, driven: Points, hits: Points) -> NDArray[np.uint8]:
    """Return the map with +y to the right and +x down, half as large as it is drawn."""
    cells = floor.cells
    colours = np.full((*cells.shape, 3), FREE, np.uint8)
    colours[cells == OCCUPIED], colours[cells < 0] = WALL, UNKNOWN
    image = Image.fromarray(np.ascontiguousarray(colours.transpose(1, 0, 2))).resize(
        (2 * cells.shape[0], 2 * cells.shape[1]), Image.Resampling.NEAREST
    )
    pen = ImageDraw.Draw(image)

    def place(point: tuple[float, float]) -> tuple[float, float]:
        return 2 * (point[1] - floor.grid.south) / floor.grid.cell, 2 * (point[0] - floor.grid.west) / floor.grid.cell

    pen.line([place(point) for point in driven], fill=PATH, width=9, joint="curve")
    for column, row in map(place, hits):
        pen.ellipse((column - 4, row - 4, column + 4, row + 4), fill=SCAN)
    column, row = place(driven[-1])
    pen.ellipse((column - 16, row - 16, column + 16, row + 16), fill=ROBOT, outline=WALL, width=4)
    return np.asarray(image.resize((cells.shape[0], cells.shape[1]), Image.Resampling.LANCZOS))


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
