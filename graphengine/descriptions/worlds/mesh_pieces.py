"""Converts static non-convex meshes to thin plates, because MuJoCo uses the convex hull of a mesh for collisions.

Otherwise a hall whose walls are one mesh would be a solid block. Each triangle becomes a thin plate behind its surface.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.descriptions.files.flat_meshes import compiled_shell
from graphengine.descriptions.files.mesh_file import MeshFile
from graphengine.descriptions.files.references import Library
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.geoms import mesh_faces, mesh_vertices
from graphengine.descriptions.shapes import Mesh
from graphengine.descriptions.worlds.mjcf_elements import written
from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import printable

MAX_PLATES = 2000
"""Maximum number of triangles of a mesh that can be converted to plates."""
THICKNESS = 0.02
"""Thickness of a plate, m."""
_FLAT = 1e-6
"""Maximum distance of a vertex in front of a face of a convex mesh, as a fraction of the mesh's size."""
_NARROWEST = 1e-4
"""Minimum height (m) of a triangle above its longest side; narrower triangles do not become plates."""


@dataclass(slots=True)
class MeshPieces:
    """Creates the MJCF meshes of one world.

    Attributes:
        library: has the content of the mesh files.
        findings: receives warnings about meshes with too many triangles.
        assets: created MJCF mesh elements, by (key of the file, scale, whether the mesh must collide exactly).
    """

    library: Library
    findings: Findings
    assets: dict[tuple[str, Vector3, bool], list[Element]] = field(default_factory=dict)

    def of(self, file: MeshFile, mesh: Mesh, *, exact: bool) -> list[Element]:
        """Return the MJCF meshes for a mesh file: one mesh, or one plate per triangle.

        Plates are used if `exact` is true, i.e. the mesh is a static collider, and the mesh is not convex.
        """
        key = (file.key, mesh.scale, exact)
        if key not in self.assets:
            made = self._plates(file, mesh) if exact else []
            whole = {"file": file.key, "scale": written(*mesh.scale), "inertia": "shell"}
            made = made or [Element("mesh", whole, mesh.element.span)]
            first = sum(map(len, self.assets.values()))
            for number, element in enumerate(made, first):
                element.attributes["name"] = f"mesh_{number}"
            self.assets[key] = made
        return self.assets[key]

    def _plates(self, file: MeshFile, mesh: Mesh) -> list[Element]:
        """Return one MJCF mesh per triangle of a mesh file; an empty list if the mesh is convex or has too many triangles."""
        corners = hollow_triangles(self.library.assets[file.key], file.key, mesh.scale)
        if corners is None:
            return []
        if len(corners) > MAX_PLATES:
            name = printable(mesh.filename)
            text = f"{name!r} has {len(corners)} triangles and is not convex: its convex hull is used for collisions"
            advice = f"use boxes, or a mesh of at most {MAX_PLATES} triangles, whose exact shape is used for collisions"
            self.findings.add("W302", text, mesh.element.span, advice)
            return []
        span = mesh.element.span
        return [Element("mesh", {"inertia": "shell", "vertex": written(*plate)}, span) for plate in plates(corners)]


def hollow_triangles(data: bytes, name: str, scale: Sequence[float]) -> Floats | None:
    """Return the triangles of a mesh file as MuJoCo reads it; None if the mesh is convex, or if MuJoCo rejects the file.

    The result has the corners in m, counter-clockwise seen from outside, shape (number of triangles, 3, 3). To find out whether
    the mesh is convex, only the first `MAX_PLATES` + 1 triangles are tested. A rejected file is not reported here, but later,
    when the world is compiled.

    Args:
        data: content of the mesh file.
        name: name of the file; its suffix determines the format.
        scale: scale factors along x, y and z.
    """
    model = compiled_shell(name, data)
    if model is None:
        return None
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.mesh_quat[0])
    vertices = (mesh_vertices(model, 0) @ rotation.reshape(3, 3).T + model.mesh_pos[0]) * np.array(scale)
    corners = vertices[mesh_faces(model, 0)]
    if _volume(corners) < 0.0:
        corners = corners[:, ::-1]
    return None if _convex(corners[: MAX_PLATES + 1], vertices) else corners


def _volume(corners: Floats) -> float:
    """Return the volume that triangles enclose, m3; negative if they are clockwise seen from outside."""
    first, second, third = (corners[:, index] - corners[0, 0] for index in range(3))
    return float(np.einsum("ij,ij->", first, np.cross(second, third))) / 6.0


def _convex(corners: Floats, vertices: Floats) -> bool:
    """Return whether all vertices lie behind the planes of the given triangles."""
    normals = _normals(corners)
    size = float(np.ptp(vertices, axis=0).max())
    return not any(
        ((vertices - triangle[0]) @ normal).max() > _FLAT * size
        for triangle, normal in zip(corners, normals, strict=True)
    )


def _normals(corners: Floats) -> Floats:
    """Return unit normals of triangles; zero for triangles without area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    units: Floats = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    return units


def plates(corners: Floats) -> Iterator[list[float]]:
    """Yield the six corners (18 numbers, m) of a plate behind each triangle; very narrow triangles are skipped."""
    for triangle, normal in zip(corners, _normals(corners), strict=True):
        sides = np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1)
        area = float(np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])))
        if area > _NARROWEST * float(sides.max()):
            yield np.concatenate([triangle, triangle - THICKNESS * normal]).ravel().tolist()
