"""Draw the point cloud of a robot's 3D lidar over a picture of the warehouse.

    python -m tests.pictures.cloud docs/pictures/cloud.png

The points are those of the PointCloud2 message that the graph `publishers/points` sends, coloured by their height.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import graphengine as ge
from graphengine.api.pictures import simulated, write_png
from graphengine.devices.rotation import Pose, rotate
from graphengine.physics.pictures.frame_capture import Lens
from graphengine.physics.pictures.rendering import Image
from graphengine.physics.simulation import Simulation
from graphengine.physics.views import framing, views

FILES = {
    "robot.yaml": """format: 1
robot: mapper
extends: robots/dd100.yaml
sensors:
  top_lidar: {type: lidar, profile: lidar_3d_32, parent: base_link/chassis_link, position: [-0.1, 0.0, 0.35]}
graphs:
  points: {use: graphs/publishers/points.yaml, parameters: {lidar: base_link/chassis_link/top_lidar/Lidar, frame: top_lidar}}
""",
    "scene.yaml": """format: 1
scene: mapping
world: worlds/full_warehouse.xml
physics: {tick_rate: 60, substeps: 4}
settle: true
robots:
  dd100: {use: robot.yaml, position: [-3.0, 6.0, 0.025], orientation: {rpy_deg: [0, 0, 90]}, namespace: mapper}
""",
}
COLOURS = np.array([(40, 60, 190), (0, 170, 220), (60, 210, 110), (245, 215, 50), (245, 90, 40)], float)
"""Colours of points from the floor to `HIGHEST`."""
HIGHEST = 3.2
"""Height from which all points have the last colour, m."""
BEHIND = (-4.2, 1.6, 3.6)
"""Position of the camera in the frame of the robot, m."""


def draw(path: Path, size: tuple[int, int] = (960, 540)) -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in FILES.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        scene = ge.load(Path(folder) / "scene.yaml")
        (topic,) = (claim.topic for claim in scene.topics if claim.message_type.endswith("/PointCloud2"))
        with scene.session() as sim:
            cloud = sim.subscribe(topic)
            sim.run(0.5)
            write_png(_picture(simulated(sim._runner.session.services.world), cloud.latest, size), path)


def _picture(world: Simulation, message: Any, size: tuple[int, int]) -> NDArray[np.uint8]:
    robot = world.body(next(world.stage.prims("robot"))).pose()
    lidar = next(prim for prim in world.stage.prims("lidar") if "top_lidar" in prim.path)
    points = _in_world(_points(message), world.frame(lidar).pose())
    base, (eye,) = np.array(robot[0]), _in_world(np.array([BEHIND]), robot)
    ahead = _in_world(np.array([(3.0, 0.0, 0.6)]), robot)[0]
    back = (eye - ahead) / np.linalg.norm(eye - ahead)
    lens = Lens.pinhole(size, size[1], 0.05, 100.0)
    view = views.View(framing.camera_pose(eye, back), lens, (float(base[0]), float(base[1]), 0.0), 30.0)
    image = views.draw(world, view)
    return _with_points(image, lens, (points - eye) @ framing.camera_axes(back).T, points[:, 2])


def _points(message: Any) -> NDArray[np.float64]:
    """Return the points of a PointCloud2 in its frame, m, shape (n, 3)."""
    places = {field.name: field.offset for field in message.fields}
    packed = np.frombuffer(bytes(message.data), np.uint8).reshape(-1, message.point_step)
    return np.stack([packed[:, places[axis] : places[axis] + 4].copy().view("<f4")[:, 0] for axis in "xyz"], axis=1)


def _in_world(points: NDArray[Any], pose: Pose) -> NDArray[np.float64]:
    axes = np.array([rotate(pose[1], axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))])
    return np.asarray(points @ axes + pose[0], float)


def _with_points(
    image: Image, lens: Lens, seen: NDArray[np.float64], heights: NDArray[np.float64]
) -> NDArray[np.uint8]:
    """Return the image, a little paler, with a dot for each point that nothing in it hides.

    Args:
        image: the rendered image.
        lens: its lens.
        seen: the points in the frame of the camera (right, up, back), m.
        heights: their heights above the floor, m.
    """
    width, height = lens.size
    depth = -seen[:, 2]
    scale = height / 2 / lens.half_height / np.maximum(depth, 1e-6)
    columns, rows = width / 2 + seen[:, 0] * scale, height / 2 - seen[:, 1] * scale
    inside = (depth > lens.near) & (columns >= 1) & (columns < width - 1) & (rows >= 1) & (rows < height - 1)
    columns, rows = columns.astype(int, casting="unsafe"), rows.astype(int, casting="unsafe")
    inside[inside] = depth[inside] < 1.02 * image.depth[rows[inside], columns[inside]] + 0.05
    shares = np.clip(heights / HIGHEST, 0.0, 1.0) * (len(COLOURS) - 1)
    steps = np.arange(len(COLOURS))
    colours = np.stack([np.interp(shares, steps, COLOURS[:, channel]) for channel in range(3)], axis=1)
    pixels = 0.55 * image.rgb + 0.45 * 70.0
    order = np.flatnonzero(inside)[np.argsort(-depth[inside])]
    for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
        pixels[rows[order] + row, columns[order] + column] = colours[order]
    return pixels.astype(np.uint8)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
