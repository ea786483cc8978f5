"""A drawing as self-contained SVG, without scripts, external fonts or images.

All text from files goes through `escape`. Colours adapt to the viewer's light or dark theme. Execution and value wires differ
in line width and arrow head, not only in colour.
"""

from __future__ import annotations

import html
from collections.abc import Collection, Iterator, Sequence
from importlib import resources
from itertools import pairwise
from string import Template

from graphengine.drawing.geometry import Point, Route
from graphengine.drawing.nested_layout import arrange
from graphengine.drawing.node_box import HEAD, MARGIN, NAME_SIZE, PORT_SIZE, TYPE_SIZE, Label, NodeBox
from graphengine.drawing.text_metrics import FONTS, fitted, width
from graphengine.drawing.view_model import GraphView, WireView
from graphengine.format.diagnostics import Finding
from graphengine.format.wording import printable

_SPACE = 18.0
"""Distance around the drawing and between two graphs, px."""
_TITLE_SIZE = 16.0
_LINE = 17.0
_ROUND = 6.0
"""Radius of the corners of wires, px."""
_ARROW = 9.0
_LEAST = 560.0
"""Minimum width of a drawing, px, so that the legend of wires fits."""
_ABOUT = 2000
"""Maximum length of a tooltip, characters."""

_STYLES = {
    "exec": ("execution", "exec-tip"),
    "later": ("execution in a later tick", "exec-tip"),
    "data-wire": ("value", "data-tip"),
    "circle": ("in a circle", "wrong-tip"),
    "refused": ("connection with a mistake", "wrong-tip"),
}
"""A dict from styles of wires to texts in the legend and CSS classes of arrow heads."""

STYLE = "\n" + Template(resources.files(__package__).joinpath("svg.css").read_text(encoding="utf-8")).substitute(
    fonts=FONTS,
    title_size=f"{_TITLE_SIZE:g}",
    name_size=f"{NAME_SIZE:g}",
    type_size=f"{TYPE_SIZE:g}",
    port_size=f"{PORT_SIZE:g}",
)
"""Style sheet of all drawings; viewers without media queries show the light theme."""


def draw(views: Sequence[GraphView], *, named: bool = False) -> str:
    """Return the text of an SVG file with all graphs, one below the other.

    Args:
        views: graphs to draw.
        named: whether the SVG has attributes for scripts: `data-node` of each node, `data-port` of each port (`left:name`), and
            `data-from` and `data-to` of each wire, with the names of its nodes.

    Raises:
        UsageError: the layout library is not installed.
    """
    parts = [_draw_graph(view, named=named) for view in views]
    wide = max([_LEAST, *(drawn for _, drawn, _ in parts)]) + 2 * _SPACE
    body: list[str] = []
    top = _SPACE
    for lines, _, height in parts:
        body += [f'<g transform="translate({_number(_SPACE)} {_number(top)})">', *lines, "</g>"]
        top += height + 2 * _SPACE
    body += _signs({_style(wire) for view in views for wire in view.wires}, _SPACE, top)
    high = top + _SPACE + 4
    size = f'width="{_number(wide)}" height="{_number(high)}" viewBox="0 0 {_number(wide)} {_number(high)}"'
    names = ", ".join(view.title for view in views)
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" xml:space="preserve" {size}>',
            f"<title>{escape(f'ActionGraph {names}')}</title>",
            f"<style>{STYLE}</style>",
            f'<rect class="page" width="{_number(wide)}" height="{_number(high)}"/>',
            *body,
            "</svg>",
            "",
        ]
    )


def escape(text: str) -> str:
    """Return untrusted text, cut to `_ABOUT` characters, in a form that is legal in SVG."""
    lines = text[:_ABOUT].split("\n")
    return html.escape("\n".join(map(printable, lines)))


def _number(value: float) -> str:
    return f"{round(value, 1) + 0.0:g}" if abs(value) < 1e5 else f"{round(value)}"


def _rectangle(x: float, y: float, wide: float, high: float) -> str:
    return f'x="{_number(x)}" y="{_number(y)}" width="{_number(wide)}" height="{_number(high)}"'


def _text(x: float, y: float, text: str, kind: str) -> str:
    return f'<text class="{kind}" x="{_number(x)}" y="{_number(y)}">{escape(text)}</text>'


def _draw_graph(view: GraphView, *, named: bool) -> tuple[list[str], float, float]:
    """Return the SVG of a graph with the top left corner at (0, 0), and the graph's width and height in px."""
    layout = arrange(view)
    heading, head_width, head_height = _heading(view, max(layout.width, _LEAST))
    lines = [*heading, f'<g transform="translate(0 {_number(head_height)})">']
    for frame in layout.frames:
        x, y = frame.corner
        file = view.groups[frame.name][0]
        caption = f"{frame.name.rpartition('/')[2]}  {file}".rstrip()
        lines += [
            '<g class="subgraph">',
            f'<rect class="group" {_rectangle(x, y, frame.width, frame.height)} rx="8"/>',
            f"<title>{escape(f'subgraph {frame.name} {file}')}</title>",
            _text(x + MARGIN, y + 17, fitted(caption, PORT_SIZE, frame.width - 2 * MARGIN), "caption"),
            "</g>",
        ]
    on_top = {"": 0, "refused": 2, "circle": 3}
    drawn = list(zip(view.wires, layout.routes, strict=True))
    order = sorted(drawn, key=lambda pair: on_top[pair[0].mistake] or pair[0].form != "data")
    lines += [line for wire, route in order if route for line in _wire(wire, route, named=named)]
    for node, box in layout.boxes.items():
        lines += _node(box, layout.corners[node], named=named)
    lines.append("</g>")
    return lines, max(layout.width, head_width), head_height + layout.height


def _heading(view: GraphView, limit: float) -> tuple[list[str], float, float]:
    """Return the SVG of a graph's heading, and the heading's width and height in px.

    The heading has the name, the prim path, the rate, and the findings that belong to no node.
    """
    title = fitted(view.title, _TITLE_SIZE, limit, bold=True)
    caption = fitted(view.caption, PORT_SIZE, limit)
    lines = [_text(0, 14, title, "title"), _text(0, 33, caption, "caption")]
    wide = max(width(title, _TITLE_SIZE, bold=True), width(caption, PORT_SIZE))
    y = 33.0
    for finding in view.findings:
        y += _LINE
        text = fitted(_sentence(finding), TYPE_SIZE, limit, bold=True)
        lines.append(_mark(0, y, text, finding.severity, _about(finding)))
    return lines, wide, y + 16


def _mark(x: float, y: float, text: str, severity: str, about: str) -> str:
    return f"<g>{_text(x, y, text, f'mark {severity}')}<title>{escape(about)}</title></g>"


def _sentence(finding: Finding) -> str:
    return f"{finding.severity} {finding.code}: {finding.message}"


def _about(finding: Finding) -> str:
    return "\n".join((_sentence(finding), *finding.help))


def _node(box: NodeBox, corner: Point, *, named: bool) -> list[str]:
    """Return the SVG of a node's box with tooltip, labels and ports."""
    told = [_about(finding) for finding in box.view.findings]
    about = "\n\n".join([box.view.about, *told])
    kind = f"node {box.view.kind} {box.severity}".rstrip()
    name = f' data-node="{escape(box.view.id)}"' if named else ""
    wide, high = _number(box.width), _number(box.height)
    round_head = f"M0 {HEAD:g}V6q0-6 6-6H{_number(box.width - 6)}q6 0 6 6V{HEAD:g}z"
    lines = [
        f'<g class="{kind}"{name} transform="translate({_number(corner[0])} {_number(corner[1])})">',
        f"<title>{escape(about)}</title>",
        f'<rect class="box" width="{wide}" height="{high}" rx="6"/>',
        f'<path class="head" d="{round_head}"/>',
        f'<rect class="box" width="{wide}" height="{high}" rx="6" fill-opacity="0"/>',
        _text(MARGIN, 17, box.name, "name"),
        _text(MARGIN, 33, box.type_name, "type"),
    ]
    lines += [_port(label, box.width, named=named) for label in box.labels]
    lines += [_mark(MARGIN, mark.y + 4, mark.text, mark.severity, mark.about) for mark in box.marks]
    return [*lines, "</g>"]


def _port(label: Label, box_width: float, *, named: bool) -> str:
    right = label.side == "right"
    x = box_width - MARGIN if right else MARGIN
    value = f'<tspan class="value"> {escape(label.value)}</tspan>' if label.value else ""
    anchor = ' text-anchor="end"' if right else ""
    text = f'<text x="{_number(x)}" y="{_number(label.y + 4)}"{anchor}>{escape(label.name)}{value}</text>'
    name = f' data-port="{label.side}:{escape(label.view.name)}"' if named else ""
    return f'<g class="port"{name}><title>{escape(label.view.about)}</title>{text}</g>'


def _wire(wire: WireView, route: Route, *, named: bool) -> list[str]:
    """Return the SVG of a wire with rounded corners and an arrow head."""
    style = _style(wire)
    x, y = route[-1]
    line = _path([*route[:-1], (x - _ARROW, y)])
    ends = f' data-from="{escape(wire.source[0])}" data-to="{escape(wire.target[0])}"' if named else ""
    return [
        f'<g class="connection"{ends}><title>{escape(wire.about)}</title>',
        f'<path class="wire {style}" d="{line}"/>',
        _tip(x, y, style),
        "</g>",
    ]


def _style(wire: WireView) -> str:
    """Return the key of a wire's style in `_STYLES`."""
    return wire.mistake or ("data-wire" if wire.form == "data" else wire.form)


def _tip(x: float, y: float, style: str) -> str:
    half = 3.5 if style == "data-wire" else 5.0
    triangle = f"M{_number(x - 1)} {_number(y)}l-{_ARROW:g}-{half:g}v{2 * half:g}z"
    return f'<path class="{_STYLES[style][1]}" d="{triangle}"/>'


def _path(route: Sequence[Point]) -> str:
    """Return the SVG path of a polyline with rounded corners."""
    parts = [f"M{_number(route[0][0])} {_number(route[0][1])}"]
    for before, (corner, after) in zip(route, pairwise(route[1:]), strict=False):
        radius = min(_ROUND, _length(before, corner) / 2, _length(corner, after) / 2)
        begin, end = _towards(corner, before, radius), _towards(corner, after, radius)
        parts.append(f"L{_number(begin[0])} {_number(begin[1])}")
        parts.append(f"Q{_number(corner[0])} {_number(corner[1])} {_number(end[0])} {_number(end[1])}")
    parts.append(f"L{_number(route[-1][0])} {_number(route[-1][1])}")
    return "".join(parts)


def _length(one: Point, other: Point) -> float:
    return abs(one[0] - other[0]) + abs(one[1] - other[1])


def _towards(corner: Point, other: Point, distance: float) -> Point:
    length = _length(corner, other) or 1.0
    x, y = (here + (there - here) / length * distance for here, there in zip(corner, other, strict=True))
    return x, y


def _signs(styles: Collection[str], x: float, y: float) -> Iterator[str]:
    """Yield the SVG of the legend with an entry for each style of wires in the drawing."""
    for style, (meaning, _) in _STYLES.items():
        if style not in styles:
            continue
        yield f'<path class="wire {style}" d="M{_number(x)} {_number(y)}h24"/>'
        yield _tip(x + 24 + _ARROW, y, style)
        yield _text(x + 40, y + 4, meaning, "sign")
        x += 40 + width(meaning, TYPE_SIZE) + 24
