"""The visible shapes of a world's bodies, as data for programs that draw the world themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import Pose, Vector3

ShapeKind = Literal["plane", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"]
Surface = tuple[NDArray[np.float32], NDArray[np.int32]]
"""A triangle mesh: vertices in m, shape (n, 3), and the vertex indices of each triangle, shape (m, 3)."""


@dataclass(frozen=True, slots=True)
class VisibleShape:
    """One visible shape of a body.

    Attributes:
        kind: geometric form of the shape.
        size: half lengths along the shape's axes, m. For a capsule, the radius and the half length of the cylindrical part. For a
            plane, 0 along sides that are infinite.
        body: index of the shape's body in `World.poses`.
        pose: pose of the shape in the body's frame.
        colour: red, green, blue and opacity, 0 to 1.
        mesh: for a mesh, the name of the triangle mesh in `Bodies.surfaces`; empty for other kinds.
        texture: name of the texture in `Bodies.textures`, whose colours are multiplied by `colour`; empty without a texture.
        repeats: repetitions of the texture per metre along the shape's x and y axes, starting at the corner with the smallest x
            and the largest y; zero for a mesh with texture coordinates.
    """

    kind: ShapeKind
    size: Vector3
    body: int
    pose: Pose
    colour: tuple[float, float, float, float]
    mesh: str = ""
    texture: str = ""
    repeats: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Bodies:
    """All bodies of a world with their visible shapes. The data changes only when a robot is added or removed.

    Attributes:
        names: names of the bodies; the first is the world.
        moving: whether each body can move.
        shapes: visible shapes of all bodies.
        surfaces: a dict from names to triangle meshes.
        textures: a dict from names to textures: arrays of shape (height, width, channels) with the top row first.
        coordinates: a dict from mesh names to texture coordinates of the triangle corners, shape (triangles, 3, 2). The origin is
            the upper left corner of the texture. Meshes without texture coordinates are left out.
    """

    names: Sequence[str] = ()
    moving: Sequence[bool] = ()
    shapes: Sequence[VisibleShape] = ()
    surfaces: Mapping[str, Surface] = field(default_factory=dict)
    textures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    coordinates: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
