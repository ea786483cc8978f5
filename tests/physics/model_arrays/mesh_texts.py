"""Writes small meshes as STL, OBJ and COLLADA."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from tests.descriptions.files.test_meshes import BLUE, RED, collada, instance

Triangle = tuple[tuple[float, float, float], ...]
POINTS = ((0.0, 0.0, 0.0), (0.3, 0.02, 0.01), (0.01, 0.2, 0.0), (0.03, 0.05, 0.15), (0.21, 0.17, 0.11))
"""Corners of a solid of six triangles without symmetry, m."""
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4))
FLAT = (((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.2, 0.0)), ((0.3, 0.0, 0.0), (0.3, 0.2, 0.0), (0.0, 0.2, 0.0)))
"""A rectangle, from which a collider becomes a plate."""


def solid(stretch: float) -> list[Triangle]:
    """Return the triangles of the solid, stretched along x."""
    corners = [(x * stretch, y, z) for x, y, z in POINTS]
    return [tuple(corners[index] for index in face) for face in FACES]


def binary_stl(triangles: Sequence[Triangle]) -> bytes:
    """Return a binary STL file."""
    records = [struct.pack("<12fH", 0, 0, 0, *(value for corner in each for value in corner), 0) for each in triangles]
    return bytes(80) + struct.pack("<I", len(records)) + b"".join(records)


def ascii_stl(triangles: Sequence[Triangle]) -> bytes:
    """Return an ASCII STL file."""
    lines = ["solid part"]
    for triangle in triangles:
        corners = [f"vertex {x} {y} {z}" for x, y, z in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""]).encode()


def obj(triangles: Sequence[Triangle]) -> bytes:
    """Return an OBJ file in which triangles share their corners."""
    corners = list(dict.fromkeys(corner for triangle in triangles for corner in triangle))
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += ["f " + " ".join(str(corners.index(corner) + 1) for corner in triangle) for triangle in triangles]
    return "\n".join([*lines, ""]).encode()


def dae() -> bytes:
    """Return a COLLADA file with a red and a blue triangle, in a node that is turned, and in centimetres."""
    node = f"<node><rotate>1 2 3 40</rotate><translate>10 0 5</translate>{instance('red', 'blue')}</node>"
    return collada(node, '<unit meter="0.01"/>', materials=(RED, BLUE))
