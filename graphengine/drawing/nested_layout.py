"""Layout of a graph with nested subgraphs.

Each subgraph has its own layout, and is a box in the layout of the graph around it. A wire into or out of a subgraph has a port
on the border of the subgraph. In the layout of the subgraph, this port is a box without width in the first or last column.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

from graphengine.drawing import column_layout, layered_layout, manual_layout
from graphengine.drawing.geometry import Arrangement, LayoutBox, LayoutLink, Point, Route, bounds, simplified
from graphengine.drawing.node_box import NodeBox, make_box
from graphengine.drawing.view_model import GraphView, PortPlace, WireView

MAX_LEVEL, MAX_WHOLE = 200, 600
"""Maximum number of boxes plus links in a level, and in the whole graph, for layouts in cubic time."""

_PADDING = 18.0
"""Distance between the border of a subgraph and its contents, px."""
_CAPTION = 24.0
"""Height of the line with a subgraph's name, px."""
_PIN = 1.0
"""Half the height of the box that represents a port on a border, px."""

Pin = tuple[str, bool, PortPlace]
"""A port on a subgraph's border: the subgraph, whether wires lead inward, and the node and port to which they lead inside."""


@dataclass(slots=True)
class SubgraphFrame:
    """The border of a subgraph in a drawing."""

    name: str
    corner: Point
    width: float
    height: float


@dataclass(slots=True)
class GraphLayout:
    """A complete layout: dicts from node ids to boxes and to corners, borders of subgraphs, and the polyline of each wire."""

    boxes: dict[str, NodeBox]
    corners: dict[str, Point] = field(default_factory=dict)
    frames: list[SubgraphFrame] = field(default_factory=list)
    routes: list[Route] = field(default_factory=list)
    width: float = 0.0
    height: float = 0.0


@dataclass(slots=True)
class _Level:
    """The layout of one subgraph, or of the outermost graph, relative to its top left corner."""

    width: float
    height: float
    corners: dict[str, Point]
    """A dict from ids of the nodes and subgraphs directly in this level to their top left corners."""
    pins: dict[Pin, float]
    """A dict from ports on the border to their vertical positions, px."""
    pieces: dict[int, Route]
    """A dict from the numbers of wires to their sections in this level."""


def arrange(view: GraphView) -> GraphLayout:
    """Return the layout of a graph with its subgraphs.

    Raises:
        UsageError: the layout library is not installed.
    """
    layout = GraphLayout({node.id: make_box(node) for node in view.nodes})
    levels: dict[str, _Level] = {}
    for group in sorted(view.groups, key=lambda group: (-group.count("/"), group)):
        levels[group] = _arrange_level(group, view, layout.boxes, levels)
    levels[""] = _arrange_level("", view, layout.boxes, levels)
    pieces: dict[int, list[Route]] = {}
    _put(layout, levels, "", (0.0, 0.0), pieces)
    layout.routes = [_joined(pieces.get(number, [])) for number in range(len(view.wires))]
    layout.width, layout.height = levels[""].width, levels[""].height
    return layout


def _put(layout: GraphLayout, levels: dict[str, _Level], group: str, at: Point, pieces: dict[int, list[Route]]) -> None:
    """Add a subgraph and all its inner subgraphs to the layout, in coordinates of the drawing."""
    level = levels[group]
    for number, route in level.pieces.items():
        pieces.setdefault(number, []).append(tuple((x + at[0], y + at[1]) for x, y in route))
    for name, (x, y) in level.corners.items():
        there = (at[0] + x, at[1] + y)
        if name in layout.boxes:
            layout.corners[name] = there
        else:
            layout.frames.append(SubgraphFrame(name, there, levels[name].width, levels[name].height))
            _put(layout, levels, name, there, pieces)


def _joined(pieces: Sequence[Route]) -> Route:
    """Return the sections of a wire, in any order, joined to a polyline; each section begins where another ends."""
    if not pieces:
        return ()
    starts = {_place(piece[0]): piece for piece in pieces}
    targets = {_place(piece[-1]) for piece in pieces}
    following = next((piece for piece in pieces if _place(piece[0]) not in targets), pieces[0])
    points: list[Point] = []
    for _ in pieces:
        points += following
        following = starts.get(_place(following[-1]), ())
        if not following:
            break
    return simplified(points)


def _place(point: Point) -> tuple[float, float]:
    return round(point[0], 3), round(point[1], 3)


def _arrange_level(group: str, view: GraphView, nodes: dict[str, NodeBox], levels: dict[str, _Level]) -> _Level:
    names = [node.id for node in view.nodes if node.group == group]
    names += [name for name in view.groups if name and name.rpartition("/")[0] == group]
    places = {node.id: node.place for node in view.nodes} | {name: at for name, (_, at) in view.groups.items()}
    sizes = {name: nodes[name] if name in nodes else levels[name] for name in names}
    boxes = [LayoutBox(sizes[name].width, sizes[name].height, place=places[name]) for name in names]
    numbers = {name: number for number, name in enumerate(names)}
    links: dict[LayoutLink, int] = {}
    carried: dict[int, int] = {}
    pins: dict[Pin, int] = {}

    def end(wire: WireView, *, begins: bool) -> tuple[int, float]:
        """Return the box at the beginning or end of a wire's section in this level, and the distance from its top."""
        (node, port), inner = (wire.source, wire.target) if begins else (wire.target, wire.source)
        if not _holds(group, node):
            pin = (group, begins, inner)
            if pin not in pins:
                pins[pin] = len(boxes)
                boxes.append(LayoutBox(0.0, 2 * _PIN, "first" if begins else "last"))
            return pins[pin], _PIN
        if node in numbers:
            return numbers[node], nodes[node].heights[port]
        child = _child(group, node)
        return numbers[child], levels[child].pins[child, not begins, (node, port)]

    for number, wire in enumerate(view.wires):
        if not _touches(group, wire):
            continue
        (source, source_y), (target, target_y) = end(wire, begins=True), end(wire, begins=False)
        link = LayoutLink(source, source_y, target, target_y)
        carried[number] = links.setdefault(link, len(links))
    made = _way(view, boxes, links)(boxes, list(links))
    return _framed(group, names, boxes, made, carried, pins, links)


def _way(
    view: GraphView, boxes: Sequence[LayoutBox], links: Collection[LayoutLink]
) -> Callable[[Sequence[LayoutBox], Sequence[LayoutLink]], Arrangement]:
    """Return the layout function for a level, chosen by the numbers of boxes and links."""
    whole = len(view.nodes) + len(view.wires)
    if len(boxes) + len(links) > MAX_LEVEL or whole > MAX_WHOLE:
        return column_layout.arrange
    return manual_layout.arrange if any(box.place is not None for box in boxes) else layered_layout.arrange


def _holds(group: str, node: str) -> bool:
    return not group or node.startswith(f"{group}/")


def _child(group: str, node: str) -> str:
    """Return the id of a node that is directly in a group, or of the subgraph in the group that contains the node."""
    start = len(group) + 1 if group else 0
    return node[:start] + node[start:].partition("/")[0]


def _touches(group: str, wire: WireView) -> bool:
    """Return whether a section of a wire lies in a group but outside of its subgraphs."""
    children = [_child(group, node) for node, _ in (wire.source, wire.target) if _holds(group, node)]
    return len(children) == 1 or len(set(children)) == 2 or children[:1] == [wire.source[0]]


def _framed(
    group: str,
    names: Sequence[str],
    boxes: Sequence[LayoutBox],
    made: Arrangement,
    carried: dict[int, int],
    pins: dict[Pin, int],
    links: dict[LayoutLink, int],
) -> _Level:
    """Return a level with its top left corner at (0, 0). A subgraph gets a caption and a border with ports."""
    left, top, right, bottom = bounds(boxes, made.corners, made.routes)
    padding, caption = (_PADDING, _CAPTION) if group else (0.0, 0.0)
    dx, dy = padding - left, padding + caption - top
    width, height = right - left + 2 * padding, bottom - top + 2 * padding + caption
    pieces = [[(x + dx, y + dy) for x, y in route] for route in made.routes]
    edges = {number: pin for pin, number in pins.items()}
    for link, number in links.items():
        if link.source in edges:
            pieces[number].insert(0, (0.0, pieces[number][0][1]))
        if link.target in edges:
            pieces[number].append((width, pieces[number][-1][1]))
    corners = {name: (x + dx, y + dy) for name, (x, y) in zip(names, made.corners, strict=False)}
    heights = {pin: made.corners[number][1] + _PIN + dy for pin, number in pins.items()}
    return _Level(width, height, corners, heights, {wire: simplified(pieces[n]) for wire, n in carried.items()})
