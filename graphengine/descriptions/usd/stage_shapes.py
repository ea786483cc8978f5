"""Reads geometric prims as shapes; runs in the confined process.

A form that a robot cannot have, such as a cone, a stretched sphere or a sheared box, becomes a mesh.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdPhysics

from graphengine.descriptions.files.meshes import Part, msh
from graphengine.descriptions.usd.stage_frames import (
    Matrix,
    Placed,
    StageFrames,
    UnusableError,
    given,
    number,
    text,
    vector,
)
from graphengine.descriptions.usd.stage_materials import Colour, colour_of, has_texture, physics_material
from graphengine.descriptions.usd_model import Kind, PhysicsContents, StageShape
from graphengine.devices.rotation import IDENTITY, Vector3, compose

MAX_POINTS = 2_000_000
"""Maximum number of points, and of triangle corners, of all meshes of a stage."""
_AXES = {"X": np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]), "Y": np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])}
"""Rotation from z to an axis of a cylinder, by the name of the axis."""
_FACETS = 24
"""Number of corners of a round form that becomes a mesh."""
_EQUAL = 1e-6
"""Largest relative difference of scales that count as equal; single precision has seven digits."""
_ROUND = ("Cylinder", "Capsule", "Cone", "Plane")
_BOUNDING = ("boundingCube", "boundingSphere")
_VAST = 1e6
"""Coordinate beyond which a mesh is a mistake, m."""
GEOMETRY = ("Cube", "Sphere", "Cylinder", "Cylinder_1", "Capsule", "Capsule_1", "Cone", "Mesh", "Plane")


class ShapeReader:
    """Reads the shapes of one stage, and collects their meshes.

    Args:
        frames: transforms of the stage.
        contents: receives the meshes.
    """

    def __init__(self, frames: StageFrames, contents: PhysicsContents) -> None:
        self.frames = frames
        self.contents = contents
        self._meshes: dict[bytes, int] = {}
        self._points = 0

    def read(self, prim: Usd.Prim) -> Iterator[StageShape]:
        """Yield the shapes of a prim: one that collides, and one for each colour that is visible.

        Raises:
            UnusableError: the prim has unusable values, or the stage has too many points.
        """
        solid = prim.HasAPI(UsdPhysics.CollisionAPI) and given(prim, "physics:collisionEnabled") is not False
        image = UsdGeom.Imageable(prim)
        drawn = image.ComputeVisibility() != "invisible" and image.ComputePurpose() in ("default", "render")
        if str(prim.GetTypeName()) not in GEOMETRY or not (solid or drawn):
            return
        path = str(prim.GetPath())
        if solid:
            shape = StageShape(path, "mesh", [], solid=True)
            self._form(prim, shape, None)
            self._weigh(prim, shape)
            yield shape
        for faces, colour in _coloured(prim) if drawn else ():
            shape = StageShape(path, "mesh", [], colour=colour)
            self.contents.textured = self.contents.textured or (path if has_texture(prim) else "")
            self._form(prim, shape, faces)
            yield shape

    def _weigh(self, prim: Usd.Prim, shape: StageShape) -> None:
        kilograms, metres = self.frames.kilograms, self.frames.metres
        shape.material, density = physics_material(prim)
        shape.mass = max(number(prim, "physics:mass"), 0.0) * kilograms
        own = max(number(prim, "physics:density"), 0.0)
        shape.density, shape.outranks = (own or density) * kilograms / metres**3, own > 0

    def _form(self, prim: Usd.Prim, shape: StageShape, faces: Any) -> None:
        """Set form, size and pose of a shape; `faces` are the indices of the faces of a mesh, None for all."""
        placed, kind = self.frames.placed(prim), str(prim.GetTypeName())
        axis = _AXES.get(text(prim, "axis"), np.eye(3)) if kind.startswith(_ROUND) else np.eye(3)
        stretch = self.frames.metres * (axis.T @ placed.stretch @ axis)  # along the axes of the form
        shape.pose = Placed(placed.rotation @ axis, placed.position, stretch).pose
        if kind == "Plane" and shape.solid:
            shape.kind = "plane"
            return
        if (form := _solid(prim, kind, stretch)) is not None:
            shape.kind, shape.sizes = form
            return
        points, triangles = _mesh(prim, faces) if kind == "Mesh" else _tessellated(prim, kind)
        points = points @ stretch.T
        shape.approximation = (text(prim, "physics:approximation") or "none") if shape.solid else ""
        if shape.approximation in _BOUNDING:
            shape.kind, shape.sizes, middle = _bounded(points, shape.approximation)
            shape.pose = compose(shape.pose, (middle, IDENTITY))
            return
        shape.mesh = self._keep(points, triangles[:, ::-1] if np.linalg.det(stretch) < 0 else triangles)

    def _keep(self, points: Matrix, triangles: NDArray[np.int64]) -> int:
        """Return the index of a mesh, which is added unless an equal one is known."""
        if np.abs(points).max() > _VAST:
            raise UnusableError(f"it reaches farther than {_VAST:g} m")
        self._points += len(points) + 3 * len(triangles)
        if self._points > MAX_POINTS:
            raise UnusableError(f"with it the meshes of the stage have more than {MAX_POINTS} points and corners")
        data = msh(Part(points, triangles))
        if data not in self._meshes:
            self._meshes[data] = len(self.contents.meshes)
            self.contents.meshes.append(base64.b64encode(data).decode())
        return self._meshes[data]


def _coloured(prim: Usd.Prim) -> Iterator[tuple[Any, Colour | None]]:
    """Yield the indices of the faces of each part of a visible prim that has a colour, and the colour; None means all faces."""
    subsets = UsdGeom.Subset.GetGeomSubsets(UsdGeom.Imageable(prim)) if prim.IsA(UsdGeom.Mesh) else []
    parts = [(each, np.array(each.GetIndicesAttr().Get() or (), np.int64)) for each in subsets]
    parts = [(subset, faces) for subset, faces in parts if len(faces)]
    colour = colour_of(prim)
    yield from ((faces, colour_of(subset.GetPrim()) or colour) for subset, faces in parts)
    if not parts:
        yield None, colour


def _bounded(points: Matrix, approximation: str) -> tuple[Kind, list[float], Vector3]:
    """Return the form, the sizes and the middle of the box or sphere around points."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    if approximation == "boundingCube":
        return "box", (high - low).tolist(), vector(middle)
    return "sphere", [float(np.linalg.norm(points - middle, axis=1).max())], vector(middle)


def _solid(prim: Usd.Prim, kind: str, stretch: Matrix) -> tuple[Kind, list[float]] | None:
    """Return the form and the sizes of a primitive; None if it is sheared or stretched to another form.

    Args:
        prim: prim of the primitive.
        kind: USD type of the primitive.
        stretch: matrix from the units of the prim to metres, in the axes of the form.
    """
    scales = np.abs(np.diag(stretch))
    largest = max(scales.max(), 1e-300)
    if np.abs(stretch - np.diag(np.diag(stretch))).max() > _EQUAL * largest:
        return None
    x, y, z = scales.tolist()
    circular = abs(x - y) <= _EQUAL * largest
    if kind == "Cube":
        size = _length(prim, "size", 2.0)
        return "box", [size * x, size * y, size * z]
    if kind == "Sphere" and circular and abs(x - z) <= _EQUAL * largest:
        return "sphere", [_length(prim, "radius", 1.0) * x]
    if kind in ("Cylinder", "Capsule") and circular and (kind == "Cylinder" or abs(x - z) <= _EQUAL * largest):
        default = (1.0, 2.0) if kind == "Cylinder" else (0.5, 1.0)
        sizes = [_length(prim, "radius", default[0]) * x, _length(prim, "height", default[1]) * z]
        return ("cylinder" if kind == "Cylinder" else "capsule"), sizes
    return None


def _length(prim: Usd.Prim, name: str, default: float) -> float:
    value = number(prim, name, default)
    if not (0 <= value < math.inf):
        raise UnusableError(f"its {name} is {value:g}")
    return value


def _tessellated(prim: Usd.Prim, kind: str) -> tuple[Matrix, NDArray[np.int64]]:
    """Return points and triangles of a primitive about its z axis."""
    if kind == "Plane":
        half_x, half_y = _length(prim, "width", 2.0) / 2, _length(prim, "length", 2.0) / 2
        corners = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) * (half_x, half_y, 1.0)
        return corners, np.array([[0, 1, 2], [0, 2, 3]])
    if kind == "Cube":
        half = _length(prim, "size", 2.0) / 2
        return _turned([(half * math.sqrt(2), -half), (half * math.sqrt(2), half)], 4, math.pi / 4)
    capped = kind.startswith(("Capsule", "Sphere"))
    default = 0.5 if kind.startswith("Capsule") else 1.0
    names = ("radiusBottom", "radiusTop") if kind.endswith("_1") else ("radius", "radius")
    bottom, top = (_length(prim, name, default) for name in names)
    half = 0.0 if kind == "Sphere" else _length(prim, "height", 2 * default) / 2
    if not capped:
        return _turned([(bottom, -half), (0.0 if kind == "Cone" else top, half)])
    angles = np.linspace(0.0, math.pi / 2, _FACETS // 4 + 1)
    below = [(bottom * math.sin(angle), -half - bottom * math.cos(angle)) for angle in angles]
    above = [(top * math.cos(angle), half + top * math.sin(angle)) for angle in angles]
    return _turned([*below, *above[half == 0.0 :]])


def _turned(
    profile: list[tuple[float, float]], sides: int = _FACETS, first: float = 0.0
) -> tuple[Matrix, NDArray[np.int64]]:
    """Return points and triangles of a body about z with the given radii and heights, from bottom to top, and flat ends."""
    angles = first + np.arange(sides) * (2 * math.pi / sides)
    rings = [(radius * np.cos(angles), radius * np.sin(angles), np.full(sides, height)) for radius, height in profile]
    points = np.concatenate([np.stack(ring, axis=-1) for ring in rings])
    here, last = np.arange(len(points) - sides), len(points) - sides
    beside = here - here % sides + (here + 1) % sides
    walls = [np.stack([here, beside, beside + sides], -1), np.stack([here, beside + sides, here + sides], -1)]
    fan = np.stack([np.zeros(sides - 2, int), np.arange(1, sides - 1), np.arange(2, sides)], -1)
    return points, np.concatenate([*walls, fan[:, ::-1], fan + last])


def _mesh(prim: Usd.Prim, faces: Any) -> tuple[Matrix, NDArray[np.int64]]:
    """Return points and triangles of a mesh, or of the faces with the given indices."""
    points = np.array(given(prim, "points") if given(prim, "points") is not None else (), np.float64).reshape(-1, 3)
    counts = np.array(given(prim, "faceVertexCounts") or (), np.int64)
    corners = np.array(given(prim, "faceVertexIndices") or (), np.int64)
    if not len(points) or not len(counts):
        raise UnusableError("it has no points or no faces")
    if not np.isfinite(points).all():
        raise UnusableError("a coordinate is not finite")
    if (counts < 0).any() or counts.sum() != len(corners) or ((corners < 0) | (corners >= len(points))).any():
        raise UnusableError("its faces name points that do not exist")
    starts = np.cumsum(counts) - counts
    holes = np.array(given(prim, "holeIndices") or (), np.int64)
    kept = np.zeros(len(counts), bool)
    chosen = faces[(faces >= 0) & (faces < len(counts))] if faces is not None else np.arange(len(counts))
    kept[chosen] = True
    kept[holes[(holes >= 0) & (holes < len(counts))]] = False
    spans = np.maximum(counts - 2, 0) * kept
    face = np.repeat(np.arange(len(counts)), spans)
    step = np.arange(spans.sum()) - np.repeat(np.cumsum(spans) - spans, spans)
    triangles = corners[np.stack([starts[face], starts[face] + step + 1, starts[face] + step + 2], axis=-1)]
    if not len(triangles):
        raise UnusableError("it has no faces")
    if text(prim, "orientation") == "leftHanded":
        triangles = triangles[:, ::-1]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return points[used], renumbered.reshape(-1, 3).astype(np.int64)
