"""Computes where a camera stands to show an entity: its distance for the size of the entity, and a free line of sight."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.visible import Bodies, VisibleShape
from graphengine.view.scene.carried import Carried, Floats, turned

Vector = NDArray[np.float64]
NEAREST, FARTHEST = 1.0, 12.0
"""Minimum and maximum distance of a camera from the entity that it shows, m."""
PER_RADIUS = 4.5
"""Distance of a camera per radius of the entity."""
RISES = (25.0, 40.0, 55.0, 70.0, 85.0)
"""Elevations of a camera that are tried until nothing is between it and the entity, deg."""
CLOSEST = 0.6
"""Minimum distance of a camera that something stops, m."""


@dataclass(frozen=True, slots=True)
class Boxes:
    """Bounding boxes of shapes.

    Attributes:
        carried: the centres of the boxes, which move with their bodies.
        halves: half lengths of the boxes, m, shape (n, 3).
    """

    carried: Carried
    halves: Floats

    @classmethod
    def of(cls, bodies: Bodies, rows: Collection[int]) -> Boxes:
        """Return the boxes of the shapes of bodies, without planes."""
        shapes = [shape for shape in bodies.shapes if shape.body in rows and shape.kind != "plane"]
        boxes = [_box(shape, bodies) for shape in shapes]
        carried = Carried.of([(shape.body, shape.pose) for shape in shapes])
        if shapes:
            centres = np.array([centre for centre, _ in boxes], np.float32)
            carried = Carried(carried.rows, carried.positions + turned(carried.rotations, centres), carried.rotations)
        return cls(carried, np.array([half for _, half in boxes], np.float32).reshape(-1, 3))

    def radius(self, poses: Vector, centre: Vector) -> float:
        """Return the radius of the sphere around a point that contains the boxes, m; 0 without boxes."""
        if not len(self.halves):
            return 0.0
        positions, _ = self.carried.at(poses)
        return float((np.linalg.norm(positions - centre, axis=1) + np.linalg.norm(self.halves, axis=1)).max())

    def free(self, poses: Vector, begin: Vector, end: Vector) -> float:
        """Return the part of the way from one point to another, 0 to 1, before the first box; boxes around `begin` count not."""
        if not len(self.halves) or not np.isfinite([begin, end]).all():
            return 1.0
        positions, rotations = self.carried.at(poses)
        back = rotations * np.array([1, -1, -1, -1], np.float32)
        start = turned(back, np.asarray(begin - positions, np.float32))
        way = turned(back, np.broadcast_to(np.asarray(end - begin, np.float32), positions.shape))
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (-self.halves - start) / way, (self.halves - start) / way
            enters = np.fmax.reduce(np.minimum(one, other), axis=1)
            leaves = np.fmin.reduce(np.maximum(one, other), axis=1)
        hit = (enters <= leaves) & (enters > 0.0) & (enters < 1.0)
        return float(enters[hit].min()) if hit.any() else 1.0


def _box(shape: VisibleShape, bodies: Bodies) -> tuple[Vector, Vector]:
    """Return the centre and the half lengths of a shape's bounding box in the shape's frame, m."""
    x, y, z = shape.size
    if shape.kind == "mesh":
        vertices, _ = bodies.surfaces[shape.mesh]
        low, high = vertices.min(axis=0).astype(float), vertices.max(axis=0).astype(float)
        return (low + high) / 2, (high - low) / 2
    if shape.kind == "sphere":
        return np.zeros(3), np.array([x, x, x])
    if shape.kind in ("cylinder", "capsule"):
        return np.zeros(3), np.array([x, x, y + (x if shape.kind == "capsule" else 0.0)])
    return np.zeros(3), np.array([x, y, z])


def distance_for(radius: float) -> float:
    """Return the distance from which a camera shows an entity of this radius, m."""
    return min(max(PER_RADIUS * radius, NEAREST), FARTHEST)


def stand(walls: Boxes, poses: Vector, focus: Vector, azimuth: float, distance: float) -> Vector:
    """Return the position of a camera that sees `focus`: the lowest of `RISES` with a free line of sight.

    Args:
        walls: boxes that may be in between.
        poses: poses of all bodies.
        focus: the point to see.
        azimuth: direction from `focus` to the camera about the z axis, rad.
        distance: distance from `focus` to the camera, m.
    """
    found: list[tuple[float, Vector]] = []
    for rise in np.radians(RISES):
        way = distance * np.array([np.cos(rise) * np.cos(azimuth), np.cos(rise) * np.sin(azimuth), np.sin(rise)])
        share = walls.free(poses, focus, focus + way)
        if share == 1.0:
            return np.asarray(focus + way)
        found.append((share, way))
    share, way = max(found, key=lambda one: one[0])
    return closer(focus, focus + way, share)


def closer(focus: Vector, position: Vector, share: float) -> Vector:
    """Return the position of a camera in front of what stops it after this part of the way from `focus`."""
    if share == 1.0:
        return position
    way = position - focus
    length = float(np.linalg.norm(way))
    return np.asarray(focus + way * max(0.9 * share, min(CLOSEST / length, 1.0)))
