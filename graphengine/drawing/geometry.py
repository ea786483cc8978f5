"""Boxes, links and arrangements for all layouts. Lengths are in px, x points right and y points down."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

Point = tuple[float, float]
Route = tuple[Point, ...]

GAP = (44.0, 28.0)
"""Minimum horizontal and vertical distance between two boxes, px."""


@dataclass(frozen=True, slots=True)
class LayoutBox:
    """A rectangle without a final position; `place` is the position in the graph file.

    `edge` forces the box into the first or last column.
    """

    width: float
    height: float
    edge: Literal["", "first", "last"] = ""
    place: Point | None = None


@dataclass(frozen=True, slots=True)
class LayoutLink:
    """A link from the right side of a box to the left side of another; `source_y` and `target_y` are distances from the tops."""

    source: int
    source_y: float
    target: int
    target_y: float


@dataclass(frozen=True, slots=True)
class Arrangement:
    """A layout: the top left corner of each box, and a polyline of horizontal and vertical lines for each link."""

    corners: tuple[Point, ...]
    routes: tuple[Route, ...]


def bounds(
    boxes: Sequence[LayoutBox], corners: Sequence[Point], routes: Iterable[Route]
) -> tuple[float, float, float, float]:
    """Return the left, top, right and bottom edge of the rectangle around all boxes and routes; zeros for an empty drawing."""
    points = [point for route in routes for point in route]
    points += corners
    points += [(x + box.width, y + box.height) for box, (x, y) in zip(boxes, corners, strict=True)]
    xs, ys = zip(*(points or [(0.0, 0.0)]), strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def ends(boxes: Sequence[LayoutBox], corners: Sequence[Point], link: LayoutLink) -> tuple[Point, Point]:
    """Return the start point of a link on the source box, and the end point on the target box."""
    (x, y), (other_x, other_y) = corners[link.source], corners[link.target]
    return (x + boxes[link.source].width, y + link.source_y), (other_x, other_y + link.target_y)


def simplified(points: Iterable[Point]) -> Route:
    """Return a polyline without repeated and collinear points."""
    kept: list[Point] = []
    for point in points:
        if kept and point == kept[-1]:
            continue
        if len(kept) > 1 and any(kept[-2][axis] == kept[-1][axis] == point[axis] for axis in (0, 1)):
            kept.pop()
        kept.append(point)
    return tuple(kept)
