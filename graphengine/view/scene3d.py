"""Draws the bodies of a world in viser's scene: surfaces once, then the poses of those that move."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from graphengine.devices.rotation import Pose
from graphengine.devices.visible import Bodies, Surface, VisibleShape

if TYPE_CHECKING:
    import viser

Floats = NDArray[np.float32]
FAR = 10.0
"""Distance from which on hits of a lidar have one colour, m."""
FLOOR = 200.0
"""Side of the square that stands for an infinite plane, m."""
MANY_TRIANGLES = 200_000
"""Triangles of a surface beyond which it is drawn by fewer."""


@dataclass(slots=True)
class _Batch:
    """Shapes that share a surface.

    Attributes:
        handle: viser's.
        rows: row of each shape's body in the poses.
        positions: of the shapes in the frames of their bodies, (n, 3).
        rotations: likewise, quaternions (w, x, y, z), (n, 4).
    """

    handle: Any
    rows: NDArray[np.intp]
    positions: Floats
    rotations: Floats

    def place(self, poses: NDArray[np.float64]) -> None:
        """Put the shapes where their bodies are."""
        body = poses[self.rows]
        turns = body[:, [6, 3, 4, 5]].astype(np.float32)
        self.handle.batched_positions = body[:, :3].astype(np.float32) + _turn(turns, self.positions)
        self.handle.batched_wxyzs = _multiply(turns, self.rotations)


class Scene3D:
    """The 3D part of the page."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._moving: list[_Batch] = []
        self._still: list[_Batch] = []
        self._last: NDArray[np.float64] | None = None
        self._beams: Mapping[str, Floats] = {}
        self._clouds: dict[str, Any] = {}

    def show(self, bodies: Bodies, beams: Mapping[str, Floats]) -> None:
        """Draw other bodies and lidars instead of those before."""
        self._scene.reset()
        self._scene.set_up_direction("+z")
        self._scene.configure_environment_map(None)
        self._scene.configure_default_lights(enabled=False)
        self._scene.add_light_ambient("/lights/ambient", intensity=1.2)
        self._scene.add_light_directional("/lights/sun", intensity=1.6, position=(4.0, -6.0, 10.0))
        self._still.clear()
        self._moving.clear()
        batches: defaultdict[tuple[object, ...], list[VisibleShape]] = defaultdict(list)
        for shape in bodies.shapes:
            # A box, sphere, ellipsoid or cylinder is a scaled unit one; a capsule has no such.
            form = (shape.kind, shape.mesh, shape.size if shape.kind == "capsule" else ())
            batches[(bodies.moving[shape.body], *form)].append(shape)
        for number, ((moves, *_), shapes) in enumerate(batches.items()):
            batch = self._draw(f"/bodies/{number}", shapes, bodies)
            (self._moving if moves else self._still).append(batch)
        self._last = None
        self._beams = beams
        empty = np.zeros((0, 3), np.float32)
        self._clouds = {
            path: self._scene.add_point_cloud(f"/lidar{path}", empty, empty, point_size=0.04, point_shape="circle")
            for path in beams
        }

    def scan(self, scans: Mapping[str, tuple[Pose, Floats]]) -> None:
        """Show what lidars hit, from near (red) to far (blue); those without a scan show nothing."""
        for path, cloud in self._clouds.items():
            cloud.visible = path in scans
            if path not in scans:
                continue
            (position, (x, y, z, w)), ranges = scans[path]
            hit = np.isfinite(ranges)
            turn = np.tile(np.array([w, x, y, z], np.float32), (int(hit.sum()), 1))
            cloud.points = np.array(position, np.float32) + _turn(turn, self._beams[path][hit] * ranges[hit, None])
            cloud.colors = _colours(ranges[hit])

    def move(self, poses: NDArray[np.float64]) -> None:
        """Put bodies where they are now; those that have not moved cost nothing."""
        last, self._last = self._last, poses
        if last is None or last.shape != poses.shape:
            for batch in (*self._still, *self._moving):
                batch.place(poses)
            return
        changed = (poses != last).any(axis=1)
        for batch in self._moving:
            if changed[batch.rows].any():
                batch.place(poses)

    def _draw(self, name: str, shapes: Sequence[VisibleShape], bodies: Bodies) -> _Batch:
        vertices, faces = _surface(shapes[0], bodies)
        count = len(shapes)
        colours = np.array([shape.colour for shape in shapes])
        handle = self._scene.add_batched_meshes_simple(
            name,
            vertices,
            faces,
            batched_wxyzs=np.tile(np.array([1, 0, 0, 0], np.float32), (count, 1)),
            batched_positions=np.zeros((count, 3), np.float32),
            batched_scales=np.array([_scale(shape) for shape in shapes], np.float32),
            batched_colors=(colours[:, :3] * 255).round().astype(np.uint8),
            batched_opacities=colours[:, 3].astype(np.float32) if (colours[:, 3] < 1.0).any() else None,
            flat_shading=True,
            side="double" if shapes[0].kind in ("plane", "mesh") else "front",
            lod="off",
        )
        positions = np.array([shape.pose[0] for shape in shapes], np.float32)
        rotations = np.array([shape.pose[1] for shape in shapes], np.float32)[:, [3, 0, 1, 2]]
        return _Batch(handle, np.array([shape.body for shape in shapes], np.intp), positions, rotations)


def _surface(shape: VisibleShape, bodies: Bodies) -> Surface:
    if shape.kind == "mesh":
        vertices, faces = bodies.surfaces[shape.mesh]
        if len(faces) <= MANY_TRIANGLES:
            return vertices, faces
        made = trimesh.Trimesh(vertices, faces).simplify_quadric_decimation(face_count=MANY_TRIANGLES)
    elif shape.kind == "capsule":
        made = trimesh.creation.capsule(height=2 * shape.size[1], radius=shape.size[0], count=(24, 24))
    elif shape.kind == "cylinder":
        made = trimesh.creation.cylinder(radius=1.0, height=2.0, sections=32)
    elif shape.kind in ("sphere", "ellipsoid"):
        made = trimesh.creation.icosphere(subdivisions=3)
    elif shape.kind == "plane":
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
        return corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    else:
        made = trimesh.creation.box(extents=(2.0, 2.0, 2.0))
    return np.asarray(made.vertices, np.float32), np.asarray(made.faces, np.int32)


def _scale(shape: VisibleShape) -> tuple[float, float, float]:
    x, y, z = shape.size
    if shape.kind == "sphere":
        return x, x, x
    if shape.kind == "cylinder":
        return x, x, y
    if shape.kind == "plane":
        return x or FLOOR / 2, y or FLOOR / 2, 1.0
    return (1.0, 1.0, 1.0) if shape.kind in ("capsule", "mesh") else (x, y, z)


def _colours(ranges: Floats) -> NDArray[np.uint8]:
    """Red for 0 m, over yellow and green, to blue for `FAR` and beyond."""
    near = 1.0 - np.clip(ranges / FAR, 0.0, 1.0)
    steps = np.array([(40, 90, 220), (40, 180, 160), (120, 200, 60), (250, 190, 40), (220, 40, 40)], float)
    parts = [np.interp(near, np.linspace(0.0, 1.0, len(steps)), column) for column in steps.T]
    return np.stack(parts, axis=1).astype(np.uint8)


def _multiply(a: Floats, b: Floats) -> Floats:
    """Products of quaternions (w, x, y, z), row by row."""
    aw, ax, ay, az = a.T
    bw, bx, by, bz = b.T
    product: Floats = np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=1,
    )
    return product


def _turn(q: Floats, v: Floats) -> Floats:
    """Vectors rotated by quaternions (w, x, y, z), row by row."""
    t = 2.0 * np.cross(q[:, 1:], v)
    turned: Floats = v + q[:, :1] * t + np.cross(q[:, 1:], t)
    return turned
