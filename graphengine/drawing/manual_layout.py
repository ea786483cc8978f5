"""Layout with the positions in a graph file, scaled up until no boxes overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graphengine.drawing import layered_layout, routing
from graphengine.drawing.geometry import GAP, Arrangement, LayoutBox, LayoutLink, Point, bounds

MAX_STRETCH = 6.0
"""Maximum scale factor of positions; boxes that need a larger factor get new positions."""

_CLEAR = 0.1
"""Addition to the minimum distance against overlaps by rounding errors, px."""


def arrange(boxes: Sequence[LayoutBox], links: Sequence[LayoutLink]) -> Arrangement:
    """Return an arrangement with the positions of the boxes, scaled up until no boxes overlap.

    Boxes without a position get positions in columns below the others.
    """
    corners = _corners(boxes, links)
    return Arrangement(corners, tuple(routing.routes(boxes, corners, links)))


def _corners(boxes: Sequence[LayoutBox], links: Sequence[LayoutLink]) -> tuple[Point, ...]:
    found = _stretched(boxes)
    left, top, right, bottom = bounds([boxes[index] for index in found], list(found.values()), ())
    others = [index for index, box in enumerate(boxes) if index not in found and not box.edge]
    numbers = {index: number for number, index in enumerate(others)}
    inner = [link for link in links if link.source in numbers and link.target in numbers]
    inner = [replace(link, source=numbers[link.source], target=numbers[link.target]) for link in inner]
    beside = layered_layout.arrange([boxes[index] for index in others], inner)
    x0, y0, x1, _ = bounds([boxes[index] for index in others], beside.corners, ())
    for index, (x, y) in zip(others, beside.corners, strict=True):
        found[index] = (left + x - x0, bottom + 2 * GAP[1] + y - y0)
    right = max(right, left + x1 - x0)
    for edge, side in (("first", left - 2 * GAP[0]), ("last", right + 2 * GAP[0])):
        for number, index in enumerate(index for index, box in enumerate(boxes) if box.edge == edge):
            found[index] = (side, top + (boxes[index].height + GAP[1] + _CLEAR) * number)
    return tuple(found[index] for index in range(len(boxes)))


def _stretched(boxes: Sequence[LayoutBox]) -> dict[int, Point]:
    """Return a dict from box indices to scaled positions, without boxes that need a factor above `MAX_STRETCH`."""
    kept: list[int] = []
    stretch = 1.0
    for index, box in enumerate(boxes):
        if box.place is None or box.edge:
            continue
        needed = _needed_stretch(box, box.place, [boxes[other] for other in kept])
        if needed <= MAX_STRETCH:
            kept.append(index)
            stretch = max(stretch, needed)
    places = {index: boxes[index].place or (0.0, 0.0) for index in kept}
    return {index: (x * stretch, y * stretch) for index, (x, y) in places.items()}


def _needed_stretch(box: LayoutBox, place: Point, others: Sequence[LayoutBox]) -> float:
    """Return the smallest scale factor of all positions at which a box at `place` overlaps no other box."""
    if not others:
        return 1.0
    there = np.array([other.place for other in others])
    sizes = np.array([(other.width, other.height) for other in others])
    offsets = there - np.array(place)
    distances = np.where(offsets > 0, np.array([box.width, box.height]), sizes) + np.array(GAP) + _CLEAR
    with np.errstate(divide="ignore"):
        return float(np.min(distances / np.abs(offsets), axis=1).max())
