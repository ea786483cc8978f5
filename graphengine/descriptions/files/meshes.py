"""Converts mesh files that MuJoCo cannot read to MuJoCo's MSH format, in memory.

MuJoCo reads binary STL of up to 200 000 triangles, OBJ, and its own MSH. pycollada reads COLLADA, trimesh the other formats.

For COLLADA, the node transforms and the unit are applied, but the up axis is ignored, as in RViz, Gazebo and MoveIt: some
exporters always write Y_UP, even for meshes of robots whose z axis points up.
"""

from __future__ import annotations

import codecs
import contextlib
import io
import itertools
import re
import struct
import warnings
import xml.parsers.expat
import zipfile
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1."""

AS_THEY_ARE = (".obj", ".msh")
"""Formats that are passed to MuJoCo unchanged, with few exceptions (see `needs_conversion`); so is binary STL."""
CONVERTED = (".dae", ".ply", ".glb", ".off")
READABLE = (".stl", *AS_THEY_ARE, *CONVERTED)
MAX_STL_TRIANGLES = 200_000
"""Maximum number of triangles of one STL file, as in MuJoCo; larger files are converted."""
MAX_CONVERTED_BYTES = 100_000_000
"""Maximum size of a mesh file that is converted, bytes."""
MAX_TRIANGLES = 5_000_000
"""Maximum number of triangles of a mesh file."""
MAX_NODES = 100_000
"""Maximum number of nodes of a COLLADA or glTF file."""

_ENCODINGS = ("ascii", "utf-8", "utf-16", "iso-8859-1", "iso-8859-15", "cp1252")
"""Encodings that COLLADA files declare in practice. `prepare` loads them, because later imports fail."""
_LFS = b"version https://git-lfs"
"""Beginning of a file that stands for a large file until Git LFS fetches the large file."""
_IMAGES = {".dae": b"<texture", ".glb": b'"images"'}
"""Text that is in a mesh file if its materials use images, by suffix of the format."""
_LEAST_VERTICES = 4
"""Minimum number of vertices that MuJoCo requires of a mesh."""
_STL_HEADER = 84
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_OBJ_VERTEX = re.compile(rb"(?m)^v\s")
_PLAIN_CORNER, _CORNER_WITH_MORE = re.compile(rb"(?m)^f\s+-?\d+\s"), re.compile(rb"(?m)^f\s+-?\d+/")
"""Match faces of OBJ files without, and with, normals or texture coordinates. MuJoCo refuses files that have both kinds."""


class MeshError(Exception):
    """A mesh file cannot be read; the message gives the reason."""


@dataclass(frozen=True, slots=True)
class Part:
    """The triangles of a mesh that have the same colour.

    Attributes:
        vertices: positions in m, shape (number of vertices, 3).
        faces: indices of the vertices of each triangle, counter-clockwise seen from outside, shape (number of triangles, 3).
        colour: red, green, blue and alpha, 0 to 1; None if the file has no colour.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    colour: Colour | None = None


def has_textures(data: bytes, suffix: str) -> bool:
    """Return whether a mesh file names images; its conversion keeps only plain colours."""
    return suffix in _IMAGES and _IMAGES[suffix] in data


def needs_conversion(data: bytes, suffix: str) -> bool:
    """Return whether a mesh file in a readable format must be converted, because MuJoCo cannot read the format or this file."""
    if suffix == ".obj":
        few = sum(1 for _ in itertools.islice(_OBJ_VERTEX.finditer(data), _LEAST_VERTICES)) < _LEAST_VERTICES
        return few or bool(_PLAIN_CORNER.search(data) and _CORNER_WITH_MORE.search(data))
    if suffix != ".stl":
        return suffix in CONVERTED
    return not 2 <= _binary_triangles(data) <= MAX_STL_TRIANGLES  # one triangle has too few vertices for MuJoCo


def _binary_triangles(data: bytes) -> int:
    """Return the number of triangles of a binary STL file; -1 if the length of the file does not match the number."""
    triangles = int.from_bytes(data[80:_STL_HEADER], "little")
    return triangles if len(data) == _STL_HEADER + _STL_TRIANGLE.itemsize * triangles else -1


def prepare(suffixes: Collection[str]) -> None:
    """Import the libraries that read files with these suffixes, including modules that the libraries import on demand."""
    if ".dae" in suffixes:
        import collada
        import collada.polylist
        import collada.triangleset  # noqa: F401

        for name in _ENCODINGS:
            codecs.lookup(name)
    if set(suffixes) != {".dae"}:
        import trimesh
        import trimesh.exchange.load  # noqa: F401


def convert(data: bytes, suffix: str) -> list[Part]:
    """Return the triangles of a file, one part per colour, in order of the file.

    Raises:
        MeshError: the file cannot be read, or has no triangles.
    """
    if len(data) > MAX_CONVERTED_BYTES:
        raise MeshError(f"files of more than {MAX_CONVERTED_BYTES // 1_000_000} MB are not converted")
    if data.startswith(_LFS):
        remedy = "`git lfs pull` in its repository gets the mesh"
        raise MeshError(f"the file is a pointer of Git LFS, not the mesh; {remedy}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # pycollada uses numpy.matrix
        try:
            binary = suffix == ".stl" and _binary_triangles(data) >= 0
            parts = list(_collada(data) if suffix == ".dae" else _stl(data) if binary else _by_trimesh(data, suffix))
        except MeshError:
            raise
        except Exception as error:  # for a malformed file, both libraries raise exceptions of any kind
            raise MeshError(f"the file cannot be read: {str(error) or type(error).__name__}") from error
    parts = _by_colour(parts)
    if not parts:
        raise MeshError("the file has no triangles")
    return parts


def merged(parts: list[Part]) -> Part:
    """Return all parts merged into one part without a colour."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    return Part(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def msh(part: Part) -> bytes:
    """Return a part in MuJoCo's MSH format: numbers of vertices, normals, texture coordinates and faces, then the data."""
    missing = max(_LEAST_VERTICES - len(part.vertices), 0)
    vertices = np.pad(part.vertices, ((0, missing), (0, 0)), mode="edge")
    head = struct.pack("<4i", len(vertices), 0, 0, len(part.faces))
    return head + vertices.astype("<f4").tobytes() + part.faces.astype("<i4").tobytes()


def _by_colour(parts: list[Part]) -> list[Part]:
    """Return one part per colour, because each part becomes a geom; parts with the same colour are merged."""
    colours = dict.fromkeys(part.colour for part in parts)
    same = [(colour, merged([part for part in parts if part.colour == colour])) for colour in colours]
    return [Part(part.vertices, part.faces, colour) for colour, part in same]


def stl_corners(data: bytes) -> NDArray[np.float32]:
    """Return the corners of the triangles of a binary STL file, shape (3 * number of triangles, 3)."""
    return np.frombuffer(data, _STL_TRIANGLE, offset=_STL_HEADER)["corners"].reshape(-1, 3)


def _stl(data: bytes) -> Iterator[Part]:
    """Yield the triangles of a binary STL file; corners at the same position become one vertex."""
    vertices, faces = np.unique(np.ascontiguousarray(stl_corners(data)).view("V12"), return_inverse=True)
    if len(faces):
        yield Part(vertices.view("<f4").reshape(-1, 3).astype(np.float64), faces.reshape(-1, 3))


def _by_trimesh(data: bytes, suffix: str) -> Iterator[Part]:
    import trimesh

    if suffix == ".stl" and b"facet" not in data:
        raise MeshError("the file is neither ASCII STL nor binary STL, whose length must match its number of triangles")
    data = data.decode("utf-8", "replace").encode() if suffix == ".stl" else data  # trimesh would guess its encoding
    mesh = trimesh.load_mesh(io.BytesIO(data), file_type=suffix[1:], process=False, skip_materials=True)
    if len(mesh.faces):
        yield Part(np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64))


def _collada(data: bytes) -> Iterator[Part]:
    from collada.polylist import BoundPolylist
    from collada.triangleset import BoundTriangleSet

    _refuse_doctype(data)
    if zipfile.is_zipfile(io.BytesIO(data)):  # pycollada would read a file of the archive instead
        raise MeshError("the file contains a ZIP archive")
    document = _document(data)
    if document.scene is None:
        raise MeshError("the COLLADA file has no scene")
    unit = document.assetInfo.unitmeter or 1.0
    total = 0
    for geometry, mirrored in _geometries(document.scene.nodes):
        for bound in geometry.primitives():
            primitive = bound.triangleset() if isinstance(bound, BoundPolylist) else bound
            meshed = isinstance(primitive, BoundTriangleSet) and primitive.vertex is not None
            if not meshed or not len(primitive.vertex_index):
                continue
            total += len(primitive.vertex_index)
            if total > MAX_TRIANGLES:
                raise MeshError(f"the file has more than {MAX_TRIANGLES} triangles")
            used, faces = np.unique(primitive.vertex_index, return_inverse=True)  # primitives share their vertices
            vertices, faces = np.asarray(primitive.vertex[used], np.float64) * unit, faces.reshape(-1, 3)
            yield Part(vertices, faces[:, ::-1] if mirrored else faces, _diffuse(primitive.material))


def _document(data: bytes) -> Any:
    """Return the parsed COLLADA file.

    If the file has broken references, it is read without materials, because pycollada would drop geometries with such references.
    """
    import collada

    document = collada.Collada(io.BytesIO(data), ignore=[collada.DaeError])
    if not any(isinstance(error, collada.DaeBrokenRefError) for error in document.errors):
        return document
    root = ElementTree.fromstring(data)
    for instance in root.iterfind(".//{*}instance_geometry"):
        for materials in instance.findall("{*}bind_material"):
            instance.remove(materials)
    return collada.Collada(io.BytesIO(ElementTree.tostring(root, "utf-8")), ignore=[collada.DaeError])


def _geometries(nodes: list[Any]) -> Iterator[tuple[Any, bool]]:
    """Yield each geometry of a scene, transformed to the scene's frame, and whether the transform mirrors it.

    Mirroring reverses the orientation of triangles. The order is depth first. Each use of a node counts towards `MAX_NODES`.
    """
    from collada.scene import GeometryNode, Node

    pending = [(node, np.eye(4)) for node in reversed(nodes)]
    for _ in range(MAX_NODES):
        if not pending:
            return
        node, above = pending.pop()
        if isinstance(node, GeometryNode):
            mirrored = bool(np.linalg.det(above[:3, :3]) < 0)
            yield from ((geometry, mirrored) for geometry in node.objects("geometry", above))
        elif isinstance(node, Node):
            pose = above @ node.matrix
            pending.extend((child, pose) for child in reversed(node.children))
    if pending:
        raise MeshError(f"the file has more than {MAX_NODES} nodes")


def _diffuse(material: Any) -> Colour | None:
    """Return the diffuse colour of a material with opacity 1; None for a texture.

    The opacity in the file is ignored, because exporters disagree on its meaning.
    """
    colour = getattr(getattr(material, "effect", None), "diffuse", None)
    if not isinstance(colour, tuple) or len(colour) < 3:
        return None
    red, green, blue = (min(max(float(value), 0.0), 1.0) for value in colour[:3])
    return red, green, blue, 1.0


def _refuse_doctype(data: bytes) -> None:
    """Raise `MeshError` if an XML file has a document type: its entities could refer to files or expand to unlimited text."""

    def refuse(*_: object) -> None:
        raise MeshError("the file has a document type, which is not allowed")

    def stop(*_: object) -> None:
        raise StopIteration

    parser = xml.parsers.expat.ParserCreate()
    parser.StartDoctypeDeclHandler, parser.StartElementHandler = refuse, stop
    with contextlib.suppress(StopIteration):  # raised at the root element; a document type can only precede it
        parser.Parse(data, True)
