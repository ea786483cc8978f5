"""Limits what a world may request from MuJoCo, because a few words of MJCF can mean a billion copies, texels or samples.

Everything is counted in cells of some bytes each. Work that takes MuJoCo long counts more, so that a world within the limit
also compiles within minutes.
"""

from __future__ import annotations

import math
import struct

from graphengine.physics.files.xml import Element, numbers

MAX_CELLS = 200_000_000
"""Largest number of cells of a world: eleven textures of 4096 x 4096, or 100 000 elements."""
_ELEMENT = 2000
HOW_CELLS_COUNT = f"a texel or a sample is a cell, an element or a copy of one counts {_ELEMENT}"

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
"""By tag: cells for each of the product of an element's attributes."""

_PNG = b"\x89PNG\r\n\x1a\n"


def weigh(root: Element, attached: float) -> tuple[float, Element | None]:
    """Return the number of cells that an MJCF file requests, and the element at which they exceed the limit.

    Args:
        root: root element, with includes inserted.
        attached: cells of the largest model that the file attaches.
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
    """Return the number of cells in a texture or height field file, from its first bytes: MuJoCo's formats begin with sizes."""
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
    """Return the product of all numbers in some attributes, each at least 1; 0 without any of them."""
    texts = [element.get(name) for name in names if name in element.attributes]
    return math.prod(max(abs(size), 1.0) for text in texts for size in _sizes(text)) if texts else 0.0


def _sizes(text: str) -> tuple[float, ...]:
    return numbers(text, len(text.split())) or ()
