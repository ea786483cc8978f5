"""Limits the size of worlds and robots, because a few words of MJCF can request a billion copies, texels or samples from MuJoCo.

The size is an estimate of the memory that loading takes, from the attributes of elements and the headers of files; nothing is
decoded. The factors were measured: the peak memory of a process that parses, copies and compiles a model.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping

from graphengine.descriptions.files.xml import Element, numbers
from graphengine.format.wording import listing

MAX_MEMORY = 1_500_000_000
"""Maximum estimated memory of a world with its robots, bytes: e.g. eleven textures of 4096 x 4096 texels, or 100 000 elements."""
ELEMENT = 15_000
PART = 5 * ELEMENT
"""Bytes for a link, a joint or a shape of a robot."""
_TEXEL = 7.5
"""Bytes for a texel of three channels: MuJoCo decodes it into the parsed model, and copies it to the compiled model."""
_SAMPLE, _INLINE_SAMPLE = 10, 20
"""Bytes for a sample of a height field in a file, and in the MJCF text."""
_TRIANGLE = 1000
"""Bytes for a triangle of a mesh, or for a vertex if there are more vertices: normals, bounding volumes, convex hull."""
_HULL = 1.6
"""Factor for the vertices of a mesh with few or no triangles: all of them may be corners of the convex hull."""
_KEY = 300
"""Bytes for a joint in a keyframe."""
_USER = 8
"""Bytes for a character of the longest `user` attribute, for each element: all elements get as many values as this one."""
PAIR = 5000
"""Bytes for a pair of links whose contacts are excluded; 300 000 pairs take two seconds."""
_EACH = (
    f"{ELEMENT // 1000} kB an element or copy of one, {PART // 1000} kB a robot's link, joint or shape",
    f"{_TRIANGLE} bytes a triangle or vertex of a mesh",
    f"{_TEXEL} bytes a texel of three channels",
    f"{PAIR // 1000} kB a pair of links that may not collide",
    f"{_SAMPLE} to {_INLINE_SAMPLE} bytes a sample of a height field",
)
TOO_LARGE = f"exceed the limit of {MAX_MEMORY / 1e9:g} GB of memory"
HOW_MEMORY_COUNTS = (
    "use fewer copies, smaller textures or coarser meshes; a file counts for each element that uses it",
    listing(_EACH, "estimated"),
)

_NUSER = tuple(f"nuser_{of}" for of in ("body", "jnt", "geom", "site", "cam", "tendon", "actuator", "sensor"))
_COSTS: tuple[tuple[str, float, tuple[str, ...]], ...] = (
    ("texture", _TEXEL, ("width", "height")),
    ("hfield", _INLINE_SAMPLE, ("nrow", "ncol")),
    ("camera", 10, ("resolution",)),
    ("flexcomp", 150_000, ("count",)),
    ("flexcomp", 150_000, ("cellcount",)),
    ("size", ELEMENT, ("nkey",)),
    ("size", 75, ("nuserdata",)),
    *(("size", 750_000, (name,)) for name in _NUSER),
    ("contact", 10, ("num",)),
    ("user", 75, ("dim",)),
    ("general", 75, ("actdim",)),
)
"""(tag, factor, attributes): an element with this tag counts as the product of these attributes times the factor, in bytes."""

_PNG = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers of channels of a PNG file by its colour type."""
_NOT_COUNTED = bytes(set(range(256)).difference(b"\r\n\t fvnt"))
_STL_HEADER, _STL_TRIANGLE = 84, 50


def weigh(
    root: Element, attached: float, files: Mapping[str, bytes], before: float = 0.0
) -> tuple[float, Element | None]:
    """Estimate the memory of a model that MuJoCo reads.

    Args:
        root: root element of an MJCF file, with includes inserted, in which keys replace file names.
        attached: memory of the largest model that the file may attach, bytes; each `attach` element counts as that much.
        files: contents of the files by key.
        before: memory that is already taken, bytes.

    Returns:
        The memory in bytes, including `before`, and None; if it exceeds `MAX_MEMORY`, the memory up to the first element at which
        it does, and this element.
    """
    total, joints, keys, elements, users = before, 0.0, 0.0, 0.0, 0
    sizes: dict[tuple[str, str], float] = {}
    pending = [(root, 1.0)]
    while pending:
        element, copies = pending.pop()
        if element.tag == "replicate":
            copies *= _product(element, ("count",))
        total += copies * (ELEMENT + _asked(element) + (attached if element.tag == "attach" else 0.0))
        used = [name for key, name in element.attributes.items() if key.startswith("file") and name in files]
        for name in used:
            kind = name, element.tag
            sizes[kind] = sizes[kind] if kind in sizes else memory_of_file(element.tag, files[name])
            total += sizes[kind] * (_faces(element) / len(used) if element.tag == "texture" else 1.0)
        joints += copies * (element.tag in ("joint", "freejoint"))
        keys += copies * (element.tag == "key") + (_product(element, ("nkey",)) if element.tag == "size" else 0.0)
        elements += copies
        users = max(users, len(element.get("user")))
        whole = total + keys * joints * _KEY + users * elements * _USER
        if whole > MAX_MEMORY:
            return total, element
        pending.extend((child, copies) for child in reversed(element.children))
    return whole, None


def memory_of_file(tag: str, data: bytes) -> float:
    """Return the estimated memory of one use of a file by an element with this tag, bytes; nothing is decoded."""
    if tag not in ("texture", "hfield"):
        return len(data) + _TRIANGLE * _mesh_size(data)
    width = height = source = 0
    if data.startswith(_PNG) and len(data) >= 26:
        width, height, depth, colours = struct.unpack_from(">2I2B", data, 16)
        source = _CHANNELS.get(colours, 4) * max(depth // 8, 1)
    elif len(data) >= 8:  # MuJoCo's own formats begin with the number of rows and columns
        width, height = struct.unpack_from("<2i", data)
    each = _SAMPLE + source if tag == "hfield" else _TEXEL + max(source - 3, 0)
    return float(len(data) + abs(width * height) * each)


def _faces(texture: Element) -> float:
    """Return how many times its largest image a texture takes in memory.

    A cube has six faces of equal size, even if some have no image. An image without a grid is stored once, for all faces.
    """
    channels = (_product(texture, ("nchannel",)) or 3.0) / 3.0
    if any(key.startswith("file") and key != "file" for key in texture.attributes):
        return 6.0 * channels
    cells = _product(texture, ("gridsize",)) if texture.get("type", "cube") != "2d" else 0.0
    return channels * max(6.0 / cells if cells > 1 else 1.0, 1.0)


def _mesh_size(data: bytes) -> float:
    """Return the larger of the numbers of triangles and vertices of a mesh in STL, MSH or OBJ; bare points count more."""
    if len(data) >= _STL_HEADER:
        triangles = int.from_bytes(data[80:_STL_HEADER], "little")
        if len(data) == _STL_HEADER + _STL_TRIANGLE * triangles:
            return triangles
    if len(data) >= 16:
        vertices, normals, coordinates, triangles = struct.unpack_from("<4i", data)
        if len(data) == 16 + 12 * (vertices + normals + triangles) + 8 * coordinates:
            hull = _HULL if triangles < vertices / 4 else 1.0
            return float(max(hull * vertices, triangles))
    return _obj_size(data)


def _obj_size(data: bytes) -> int:
    """Return an upper estimate of `_mesh_size` of an OBJ file, from the numbers of its lines of each kind and of its spaces."""
    kept = data.translate(None, _NOT_COUNTED)
    faces, vertices, normals, coordinates = (
        sum(kept.count(end + tag + gap) for end in (b"\n", b"\r") for gap in (b" ", b"\t"))
        for tag in (b"f", b"v", b"vn", b"vt")
    )
    corners = kept.count(b" ") + kept.count(b"\t") - 3 * (vertices + normals) - 2 * coordinates
    return max(faces, corners - 2 * faces, vertices, normals, coordinates)


def _asked(element: Element) -> float:
    asked = sum(weight * _product(element, names) for tag, weight, names in _COSTS if tag == element.tag)
    if element.tag == "mesh":  # a generated mesh has that many vertices along each of its sides
        asked += _TRIANGLE * max(map(abs, _sizes(element.get("params"))), default=0.0) ** 2
        asked += _TRIANGLE * element.get("vertex").count(" ") / 3
    if element.tag == "texture" and element.get("type", "cube") != "2d":  # six squares
        asked += 6 * _TEXEL * _product(element, ("width",)) ** 2
    return asked


def _product(element: Element, names: tuple[str, ...]) -> float:
    """Return the product of all numbers in the given attributes; numbers below 1 count as 1. Return 0 without attributes."""
    texts = [element.get(name) for name in names if name in element.attributes]
    return math.prod(max(abs(size), 1.0) for text in texts for size in _sizes(text)) if texts else 0.0


def _sizes(text: str) -> tuple[float, ...]:
    return numbers(text, len(text.split())) or ()
