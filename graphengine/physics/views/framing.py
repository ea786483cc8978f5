"""Frames robots in a perspective image: their corner points, camera positions from which these fit, free lines of sight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from graphengine.descriptions.engine import NEITHER, Bools, Floats, mujoco
from graphengine.devices.rotation import Pose, pose_of, rotate
from graphengine.devices.stage import Prim
from graphengine.physics.pictures.frame_capture import SEEN

if TYPE_CHECKING:
    from graphengine.physics.simulation import Simulation

ELEVATIONS = (18.0, 40.0, 65.0)
"""Possible elevations of a camera above a robot, best first, degrees. Several robots hide each other less from above."""
AZIMUTHS = (35.0, -35.0, 145.0, -145.0, 90.0, -90.0)
"""Possible azimuths of a camera from a robot's x axis, best first, degrees."""
ROOM = 0.1
"""Half the side of the square around a camera that must be free, divided by the camera's distance."""

_SEEN = np.array(SEEN, np.uint8)
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def corner_points(simulation: Simulation, chosen: Bools, otherwise: Floats) -> Floats:
    """Return the corners of the boxes around the visible geoms in `chosen`, in the world frame, m, shape (n, 3).

    If none is visible, return the corners of a cube of 1 m around the point `otherwise`.
    """
    model, data = simulation.model, simulation.data
    geoms = np.flatnonzero(chosen & (_SEEN[model.geom_group] > 0))
    if not len(geoms):
        cube: Floats = otherwise + 0.5 * _CORNERS
        return cube
    boxes = model.geom_aabb[geoms]
    corners = boxes[:, None, :3] + boxes[:, None, 3:] * _CORNERS
    turned = np.einsum("gij,gcj->gci", data.geom_xmat[geoms].reshape(-1, 3, 3), corners)
    points: Floats = (data.geom_xpos[geoms][:, None] + turned).reshape(-1, 3)
    return points


def robot_points(simulation: Simulation, robot: Prim) -> Floats:
    """Return the corner points of a robot; see `corner_points`."""
    model = simulation.model
    own = np.isin(model.body_rootid[model.geom_bodyid], simulation.entities.roots(robot))
    return corner_points(simulation, own, np.array(simulation.body(robot).pose()[0]))


def middle(points: Floats) -> Floats:
    """Return the centre of the box around points."""
    centre: Floats = (points.min(axis=0) + points.max(axis=0)) / 2
    return centre


def heading(simulation: Simulation, robot: Prim) -> float:
    """Return the azimuth of a robot's x axis in the world frame, rad."""
    forward = rotate(simulation.body(robot).pose()[1], (1.0, 0.0, 0.0))
    return math.atan2(forward[1], forward[0])


def direction(azimuth: float, elevation: float) -> Floats:
    """Return a unit vector in the world frame; angles in rad."""
    level = math.cos(elevation)
    return np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])


def camera_axes(back: Floats) -> Floats:
    """Return the axes of an upright camera as rows (right, up, back), given the unit vector opposite to its line of sight."""
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def camera_pose(eye: Floats, back: Floats) -> Pose:
    """Return the pose of an upright camera at the point `eye`."""
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, camera_axes(back).T.reshape(-1))
    return pose_of(eye, turn)


def fitting_offset(points: Floats, centre: Floats, back: Floats, halves: tuple[float, float]) -> Floats:
    """Return where a camera has to be so that points fill a part of its image and are in its middle.

    Args:
        points: points to show, m.
        centre: origin of the result.
        back: unit vector opposite to the camera's line of sight.
        halves: half the width and half the height of that part at a distance of 1 m, m.

    Returns:
        Position of the camera relative to `centre` along its own axes (right, up, back), m.
    """
    seen = (points - centre) @ camera_axes(back).T
    slopes = np.array(halves)
    across, depth = seen[:, :2], seen[:, 2:] * slopes
    most, least = (across + depth).max(axis=0), (across - depth).min(axis=0)
    distance = float(((most - least) / 2 / slopes).max())
    return np.array([*((most + least) / 2), max(distance, float(seen[:, 2].max()) + 0.1)])


def best_direction(simulation: Simulation, robots: Sequence[Prim], halves: tuple[float, float]) -> Floats:
    """Return a unit vector from the robots to the camera; in this direction, other bodies hide the fewest robots."""
    first = heading(simulation, robots[0]) if robots else 0.0
    each = [robot_points(simulation, robot) for robot in robots]
    points = np.concatenate(each) if each else world_points(simulation)
    roots = [root for robot in robots for root in simulation.entities.roots(robot)]
    order = sorted(ELEVATIONS, key=lambda degrees: len(robots) != 1 and degrees < 30.0)
    found, most = direction(first, math.radians(order[0])), -1
    for elevation, azimuth in product(order, AZIMUTHS):
        back = direction(first + math.radians(azimuth), math.radians(elevation))
        eye = middle(points) + fitting_offset(points, middle(points), back, halves) @ camera_axes(back)
        seen = sum(_sees(simulation, eye, middle(part), roots) for part in each)
        if seen > most:
            found, most = back, seen
        if seen == len(each):
            break
    return found


def world_points(simulation: Simulation) -> Floats:
    """Return the corner points of all geoms except planes, which may be infinite; see `corner_points`."""
    return corner_points(simulation, simulation.model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE, np.zeros(3))


def free_share(simulation: Simulation, robot: Prim, centre: Floats, eye: Floats) -> float:
    """Return how much of the way from a robot's centre to a camera is free, 0 to 1; the robot itself does not count."""
    model, way = simulation.model, eye - centre
    side = ROOM * np.linalg.norm(way) * camera_axes(way / np.linalg.norm(way))[:2]
    groups = model.geom_group.copy()
    model.geom_group[np.isin(model.body_rootid[model.geom_bodyid], simulation.entities.roots(robot))] = NEITHER
    try:
        ends = [way + x * side[0] + y * side[1] for x, y in ((0, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))]
        met = [mujoco.mj_ray(model, simulation.data, centre, end, _SEEN, True, -1, None) for end in ends]
    finally:
        model.geom_group[:] = groups
    return float(min([1.0, *(share for share in met if share >= 0.0)]))


def _sees(simulation: Simulation, eye: Floats, target: Floats, roots: Sequence[int]) -> bool:
    """Return whether a ray from `eye` to `target` meets nothing before one of the bodies `roots` or a body below them."""
    model, geom = simulation.model, np.array([-1], np.int32)
    share = mujoco.mj_ray(model, simulation.data, eye, target - eye, _SEEN, True, -1, geom)
    met = int(geom[0])
    return met < 0 or share >= 1.0 or int(model.body_rootid[model.geom_bodyid[met]]) in roots
