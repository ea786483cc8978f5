"""Visible shapes of a world's bodies, for programs that draw the world themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import Pose, Vector3

ShapeKind = Literal["plane", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"]
Surface = tuple[NDArray[np.float32], NDArray[np.int32]]
"""Vertices (n, 3) in m, and triangles (m, 3) of their indices."""


@dataclass(frozen=True, slots=True)
class VisibleShape:
    """One visible shape of a body.

    Attributes:
        kind: geometric form.
        size: half lengths along the shape's axes, m; for a capsule, its radius and the half length of its cylinder; 0 along
            infinite sides of a plane.
        body: row of the shape's body in `World.poses`.
        pose: pose in the body's frame.
        colour: red, green, blue and opacity, 0 to 1.
        mesh: for a mesh, the name of its surface in `Bodies.surfaces`; empty for other kinds.
        texture: name of its texture in `Bodies.textures`, which is multiplied by the colour; empty for no texture.
        repeats: repetitions of the texture per metre along the shape's x and y axes, starting at the corner with the smallest x
            and the largest y; zero for meshes with texture coordinates.
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
    """Everything visible in a world; it changes only when robots are added or removed.

    Attributes:
        names: names of the bodies; the first is the world.
        moving: for each body, whether it can move.
        shapes: visible shapes.
        surfaces: surfaces of meshes, by name.
        textures: textures by name, shape (height, width, channels), the top row first.
        coordinates: texture coordinates of the triangle corners by mesh name, shape (triangles, 3, 2), with the origin at the
            upper left of the texture; only for meshes that have them.
    """

    names: Sequence[str] = ()
    moving: Sequence[bool] = ()
    shapes: Sequence[VisibleShape] = ()
    surfaces: Mapping[str, Surface] = field(default_factory=dict)
    textures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    coordinates: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
