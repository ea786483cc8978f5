"""Limits the size of a world, because a few words of MJCF can request a billion copies, texels or samples from MuJoCo.

The size is counted in cells. A cell is one texel or sample, a few bytes; an element counts as many cells, according to the time
that MuJoCo needs to compile it. A world within the limit compiles within minutes.
"""

from __future__ import annotations

import math
import struct

from graphengine.physics.files.xml import Element, numbers

MAX_CELLS = 200_000_000
"""Maximum number of cells of a world. It is reached by, e.g., twelve textures of 4096 x 4096 texels, or 100 000 elements."""
_ELEMENT = 2000
HOW_CELLS_COUNT = f"a texel or sample is one cell; an element, or a copy of one, counts as {_ELEMENT} cells"

_NUSER = tuple(f"nuser_{of}" for of in ("body", "jnt", "geom", "site", "cam", "tendon", "actuator", "sensor"))
_COSTS: tuple[tuple[str, int, tuple[str, ...]], ...] = (
    ("texture", 1, ("width", "height")),
    ("hfield", 1, ("nrow", "ncol")),
    ("camera", 10, ("resolution",)),
    ("flexcomp", 20_000, ("count",)),
    ("flexcomp", 20_000, ("cellcount",)),
    ("size", 2000, ("nkey",)),
    ("size", 10, ("nuserdata",)),
    *(("size", 100_000, (name,)) for name in _NUSER),
    ("user", 10, ("dim",)),
    ("general", 10, ("actdim",)),
)
"""(tag, factor, attributes): an element with this tag counts as the product of these attributes times the factor, in cells."""

_PNG = b"\x89PNG\r\n\x1a\n"


def weigh(root: Element, attached: float) -> tuple[float, Element | None]:
    """Return the number of cells that an MJCF file requests, and the element that exceeds the limit.

    Args:
        root: root element, with includes inserted.
        attached: number of cells of the largest model that the file may attach; each `attach` element counts as that many.

    Returns:
        The number of cells, and None; or the number so far, and the element at which it exceeds `MAX_CELLS`.
    """
    total = 0.0
    pending = [(root, 1.0)]
    while pending:
        element, copies = pending.pop()
        if element.tag == "replicate":
            copies *= _product(element, ("count",))
        total += copies * (_ELEMENT + _cells(element) + (attached if element.tag == "attach" else 0.0))
        if total > MAX_CELLS:
            return total, element
        pending.extend((child, copies) for child in reversed(element.children))
    return total, None


def cells_of_file(tag: str, data: bytes) -> int:
    """Return the number of cells of a texture or height field file, read from its header; 0 for other files.

    PNG files and MuJoCo's own formats begin with the number of rows and columns.
    """
    if data.startswith(_PNG) and len(data) >= 24:
        width, height = struct.unpack_from(">2I", data, 16)
        return int(width * height)
    if tag in ("texture", "hfield") and len(data) >= 8:
        rows, columns = struct.unpack_from("<2i", data)
        return abs(int(rows * columns))
    return 0


def _cells(element: Element) -> float:
    asked = sum(weight * _product(element, names) for tag, weight, names in _COSTS if tag == element.tag)
    if element.tag == "mesh":  # a made one has that many vertices along each of its sides
        asked += max(map(abs, _sizes(element.get("params"))), default=0.0) ** 2
    if element.tag == "texture" and element.get("type", "cube") != "2d":  # six squares
        asked += 6 * _product(element, ("width",)) ** 2
    return asked


def _product(element: Element, names: tuple[str, ...]) -> float:
    """Return the product of all numbers in the given attributes; numbers below 1 count as 1. Return 0 without attributes."""
    texts = [element.get(name) for name in names if name in element.attributes]
    return math.prod(max(abs(size), 1.0) for text in texts for size in _sizes(text)) if texts else 0.0


def _sizes(text: str) -> tuple[float, ...]:
    return numbers(text, len(text.split())) or ()
