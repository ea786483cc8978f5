"""Linear-time layout for large graphs: boxes in columns, long links above all boxes.

Crossings are not minimized. Links of one port share their lines. A link to the next column runs between the two columns; any
other link goes up, along a line above all boxes, and down again.
"""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.drawing.geometry import GAP, Arrangement, LayoutBox, LayoutLink, Point, Route, ends, simplified

_LANE = 8.0
"""Distance between parallel lines, px."""
_STUB = 9.0
"""Minimum length of the straight line at a port, px."""

Port = tuple[int, float]


def arrange(boxes: Sequence[LayoutBox], links: Sequence[LayoutLink]) -> Arrangement:
    """Return an arrangement with boxes in columns and routed links, in a time linear in the number of boxes and links."""
    ranks = _ranks(boxes, links)
    lanes: dict[int, dict[Port, int]] = {gap: {} for gap in range(-1, max(ranks, default=0) + 1)}
    above: dict[Port, int] = {}
    for link in links:
        port, leaves, enters = (link.source, link.source_y), ranks[link.source], ranks[link.target] - 1
        for gap in (leaves, enters):
            lanes[gap].setdefault(port, len(lanes[gap]))
        if leaves != enters:
            above.setdefault(port, len(above))
    corners, starts = _placed(boxes, ranks, lanes)
    routes: list[Route] = []
    for link in links:
        begin, end = ends(boxes, corners, link)
        port, leaves, enters = (link.source, link.source_y), ranks[link.source], ranks[link.target] - 1
        first, last = (starts[gap] + _STUB + _LANE * lanes[gap][port] for gap in (leaves, enters))
        top = -GAP[1] - _LANE * above[port] if port in above else 0.0
        over = [(first, top), (last, top)] if leaves != enters else []
        routes.append(simplified([begin, (first, begin[1]), *over, (last, end[1]), end]))
    return Arrangement(corners, tuple(routes))


def _ranks(boxes: Sequence[LayoutBox], links: Sequence[LayoutLink]) -> list[int]:
    """Return the column number of each box, with all links to the right except for some links in cycles."""
    following: list[list[int]] = [[] for _ in boxes]
    missing = [0] * len(boxes)
    for link in links:
        if link.source != link.target:
            following[link.source].append(link.target)
            missing[link.target] += 1
    ranks = [0] * len(boxes)
    done = [False] * len(boxes)
    ready = [index for index, count in enumerate(missing) if not count]
    for first in range(len(boxes)):
        while ready or not done[first]:  # in a cycle, the first box goes ahead
            index = ready.pop() if ready else first
            done[index] = True
            for other in following[index]:
                missing[other] -= 1
                if not done[other]:
                    ranks[other] = max(ranks[other], ranks[index] + 1)
                    if not missing[other]:
                        ready.append(other)
    last = max(ranks, default=0) + 2
    return [{"": rank + 1, "first": 0, "last": last}[box.edge] for rank, box in zip(ranks, boxes, strict=True)]


def _placed(
    boxes: Sequence[LayoutBox], ranks: Sequence[int], lanes: dict[int, dict[Port, int]]
) -> tuple[tuple[Point, ...], dict[int, float]]:
    """Return the top left corner of each box, and a dict from columns to the left edges of the gaps to their right, px."""
    columns: dict[int, list[int]] = {}
    for index, rank in enumerate(ranks):
        columns.setdefault(rank, []).append(index)
    corners: dict[int, Point] = {}
    starts: dict[int, float] = {}
    x = 0.0
    for gap in sorted(lanes):
        y = 0.0
        for index in columns.get(gap, []):
            corners[index] = (x, y)
            y += boxes[index].height + GAP[1]
        starts[gap] = x + max((boxes[index].width for index in columns.get(gap, [])), default=0.0)
        x = starts[gap] + max(GAP[0], 2 * _STUB + _LANE * len(lanes[gap]))
    return tuple(corners[index] for index in range(len(boxes))), starts
