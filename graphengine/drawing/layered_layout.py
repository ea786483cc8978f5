"""Layered (Sugiyama) layout with graphlay: boxes in columns from left to right, each to the right of its inputs.

graphlay breaks cycles, assigns columns, reduces crossings, places boxes and routes links between ports. This module routes
links from a box to itself, and reserves room for them around the box.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.drawing import routing
from graphengine.drawing.geometry import GAP, Arrangement, LayoutBox, LayoutLink, Point, Route, ends, simplified
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError

_LOOP = 10.0
"""Distance between a box and its first link to itself, and between two such links, px."""
_STUB = 9.0
"""Minimum length of the straight line at the end of a link, with room for an arrow head, px."""
_CLEAR = 6.0
"""Minimum vertical distance between a box and links of other boxes, px."""
_TOUCH = 0.01
"""Maximum depth inside a box of a line that counts as part of the border, px."""

_OPTIONS: dict[str, Any] = {
    "direction": "leftright",
    "effort": "balanced",
    "spacing": {
        "layer_gap": GAP[0] - 2 * _STUB,
        "node_gap": GAP[1] - 2 * _CLEAR,
        "dummy_gap": 14.0,
        "isolated_gap": GAP[0],
    },
    "routing": {"style": "orthogonal", "lane_gap": 8.0, "bundle_parallel": False},
}


def arrange(boxes: Sequence[LayoutBox], links: Sequence[LayoutLink]) -> Arrangement:
    """Return an arrangement of boxes and links by graphlay.

    Raises:
        UsageError: graphlay is not installed.
    """
    try:
        import graphlay
    except ImportError:
        raise UsageError(f"pictures of graphs need graphlay\n  {install_command('draw')}") from None
    if not boxes:
        return Arrangement((), ())
    loops = [0] * len(boxes)
    for link in links:
        loops[link.source] += link.source == link.target
    room = [_LOOP * (count + 1) if count else 0.0 for count in loops]
    nodes = [_node(box, around) for box, around in zip(boxes, room, strict=True)]
    between = [link for link in links if link.source != link.target]
    laid = graphlay.layout({"nodes": nodes, "edges": [_edge(link, boxes, room) for link in between]}, options=_OPTIONS)
    corners = tuple(
        (node["center"]["x"] - box.width / 2, node["center"]["y"] - (box.height - around) / 2)
        for node, box, around in zip(laid.nodes, boxes, room, strict=True)
    )
    found = iter(laid.edges)
    routes: list[Route] = []
    for link in links:
        begin, end = ends(boxes, corners, link)
        if link.source == link.target:
            loops[link.source] -= 1
            routes.append(_around(begin, end, corners[link.source][1], _LOOP * (loops[link.source] + 1)))
        else:
            routes.append(_squared(begin, [(p["x"], p["y"]) for p in next(found)["points"][1:-1]], end))
    return Arrangement(corners, tuple(_mended(boxes, corners, links, routes)))


def _mended(
    boxes: Sequence[LayoutBox], corners: Sequence[Point], links: Sequence[LayoutLink], routes: Sequence[Route]
) -> Sequence[Route]:
    """Return routes that cross no box: in cyclic graphs, new routes for the few links that graphlay leads through boxes."""
    low = np.array(corners)
    high = low + np.array([(box.width, box.height) for box in boxes])
    wrong = [number for number, route in enumerate(routes) if _crosses(route, low, high)]
    around = dict(zip(wrong, routing.routes(boxes, corners, [links[number] for number in wrong]), strict=True))
    return [around.get(number, route) for number, route in enumerate(routes)]


def _crosses(route: Route, low: NDArray[np.float64], high: NDArray[np.float64]) -> bool:
    """Return whether a line of a route runs through a box."""
    for pair in pairwise(route):
        begin, end = np.min(pair, axis=0), np.max(pair, axis=0)
        if np.all((begin < high - _TOUCH) & (end > low + _TOUCH), axis=1).any():
            return True
    return False


def _node(box: LayoutBox, room: float) -> dict[str, Any]:
    size = {"width": box.width + 2 * (room + _STUB), "height": box.height + room + 2 * _CLEAR}
    return {"size": size, "shape": "box", "key": "", **({"rank": box.edge} if box.edge else {})}


def _edge(link: LayoutLink, boxes: Sequence[LayoutBox], room: Sequence[float]) -> dict[str, Any]:
    def port(box: int, side: str, y: float) -> dict[str, Any]:
        half = (boxes[box].height + room[box]) / 2 + _CLEAR
        return {"offset": {"side": side, "t": (y + room[box] + _CLEAR) / half - 1}}

    return {
        "source": link.source,
        "target": link.target,
        "weight": 1.0,
        "source_port": port(link.source, "right", link.source_y),
        "target_port": port(link.target, "left", link.target_y),
    }


def _around(begin: Point, end: Point, top: float, distance: float) -> Route:
    """Return a route from the right side of a box, above the box, to its left side."""
    right, left, above = begin[0] + distance, end[0] - distance, top - distance
    return (begin, (right, begin[1]), (right, above), (left, above), (left, end[1]), end)


def _squared(begin: Point, corners: Iterable[Point], end: Point) -> Route:
    """Return a polyline between two ports with exactly horizontal and vertical lines, close to the given corners."""
    route = [begin]
    for x, y in corners:
        last_x, last_y = route[-1]
        route.append((x, last_y) if abs(x - last_x) > abs(y - last_y) else (last_x, y))
    if len(route) > 1 and route[-1][0] == route[-2][0]:  # end at the port's height
        route[-1] = (route[-1][0], end[1])
    elif route[-1][1] != end[1]:
        middle = (route[-1][0] + end[0]) / 2
        route += [(middle, route[-1][1]), (middle, end[1])]
    return simplified([*route, end])
