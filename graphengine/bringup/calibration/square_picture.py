"""Draws the square paths that a robot drove in a calibration as SVG: commanded path, true path and odometry."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np

from graphengine.bringup.calibration.figures import Calibration, Floats, Square

PANEL, SPACE, LINE = 360.0, 56.0, 18.0
"""Side of a panel, distance around a panel, and height of a line of text, pixels."""
COMMANDED, TRUTH = "#8a8f98", "#1769aa"
ODOMETRY = ("#c2410c", "#7c3aed", "#0f766e", "#a16207")
_STYLE = (
    "text{font:12px system-ui,sans-serif;fill:#24292f}.title{font-size:15px;font-weight:600}.small{font-size:11px;fill:#57606a}"
    "path{fill:none;stroke-linejoin:round}.grid{stroke:#e5e7eb}"
)


def draw(result: Calibration) -> str:
    """Return an SVG with one panel for each square path that the robot drove; all panels have the same scale.

    Raises:
        ValueError: the calibration has no square paths.
    """
    if not result.squares:
        raise ValueError("the robot did not drive a square path in this calibration")
    topics = [one.topic for one in result.odometry]
    colours = {topic: ODOMETRY[index % len(ODOMETRY)] for index, topic in enumerate(topics)}
    extent = max(_extent(square) for square in result.squares)
    wide = SPACE + len(result.squares) * (PANEL + SPACE)
    top = SPACE + 2 * LINE
    high = top + PANEL + 2 * LINE + (len(topics) + 2) * LINE + SPACE / 2
    title = f"{result.robot}: a square with sides of {result.squares[0].side:g} m, driven by time"
    body = [_text(SPACE, SPACE / 2 + 4, title, "title")]
    for number, square in enumerate(result.squares):
        left = SPACE + number * (PANEL + SPACE)
        end = f"{1000 * square.position_error:.1f} mm, {math.degrees(square.heading_error):.2f}\N{DEGREE SIGN}"
        body.append(_text(left, top - LINE, square.direction.replace("counterclockwise", "counter-clockwise")))
        body.append(_text(left, top - 3, f"the truth ends {end} off", "small"))
        body += _panel(square, left, top, extent, colours)
    rows = [
        ("commanded", COMMANDED, "6 4"),
        ("truth", TRUTH, ""),
        *((topic, colours[topic], "2 4") for topic in topics),
    ]
    body += _legend(rows, top + PANEL + 2.4 * LINE)
    size = f'width="{wide:g}" height="{high:g}" viewBox="0 0 {wide:g} {high:g}"'
    head = [f'<svg xmlns="http://www.w3.org/2000/svg" {size}>', f"<style>{_STYLE}</style>"]
    return "\n".join([*head, f'<rect width="{wide:g}" height="{high:g}" fill="#fff"/>', *body, "</svg>", ""])


def _extent(square: Square) -> float:
    """Return half the side of the smallest area, with a margin of 8 %, that contains all paths: a multiple of 0.25 m."""
    middle = _middle(square)
    paths = [square.commanded, square.truth, *square.odometry.values()]
    farthest = max(float(np.abs(path[:, :2] - middle).max()) for path in paths if len(path))
    return math.ceil(4.0 * 1.08 * farthest) / 4.0


def _middle(square: Square) -> Floats:
    path = square.commanded[:, :2]
    return np.asarray((path.min(axis=0) + path.max(axis=0)) / 2.0)


def _panel(square: Square, left: float, top: float, extent: float, colours: dict[str, str]) -> Iterator[str]:
    """Yield the SVG elements of a panel: the grid, and the paths with x up and y to the left."""
    middle, scale = _middle(square), PANEL / (2.0 * extent)

    def place(path: Floats) -> Floats:
        offset = (path[:, :2] - middle) * scale
        return np.column_stack((left + PANEL / 2.0 - offset[:, 1], top + PANEL / 2.0 - offset[:, 0]))

    yield f'<rect x="{left:g}" y="{top:g}" width="{PANEL:g}" height="{PANEL:g}" fill="none" stroke="#d0d7de"/>'
    step = next(size for size in (0.25 * 2**n for n in count()) if extent / size <= 6)
    for axis in (0, 1):
        first = math.ceil((middle[axis] - extent) / step - 1e-9)
        last = math.floor((middle[axis] + extent) / step + 1e-9)
        for value in (number * step for number in range(first, last + 1)):
            offset = (value - middle[axis]) * scale
            if axis == 0:
                y = top + PANEL / 2.0 - offset
                yield f'<path class="grid" d="M{left:.1f} {y:.1f}h{PANEL:g}"/>'
                yield f'<text class="small" x="{left - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>'
            else:
                x = left + PANEL / 2.0 - offset
                yield f'<path class="grid" d="M{x:.1f} {top:.1f}v{PANEL:g}"/>'
                yield f'<text class="small" x="{x:.1f}" y="{top + PANEL + 15:.1f}" text-anchor="middle">{value:g}</text>'
    yield _curve(place(square.commanded), COMMANDED, "6 4", 1.5)
    yield _curve(place(square.truth), TRUTH, "", 3.0)
    for topic, path in square.odometry.items():
        if len(path):
            yield _curve(place(path), colours[topic], "2 5", 1.5)
    for path, colour in ((square.commanded, COMMANDED), (square.truth, TRUTH)):
        (x, y) = place(path)[-1]
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>'


def _curve(points: Floats, colour: str, dashes: str, width: float) -> str:
    """Return a path as an SVG element, without points that nearly equal the previous point."""
    moved = np.r_[True, np.abs(np.diff(points, axis=0)).max(axis=1) > 0.02]
    return _path("M" + " ".join(f"{x:.1f} {y:.1f}" for x, y in points[moved].tolist()), colour, dashes, width)


def _path(shape: str, colour: str, dashes: str, width: float) -> str:
    style = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'<path d="{shape}" stroke="{colour}" stroke-width="{width:g}"{style}/>'


def _legend(rows: Sequence[tuple[str, str, str]], top: float) -> Iterator[str]:
    for row, (name, colour, dashes) in enumerate(rows):
        y = top + row * LINE
        yield _path(f"M{SPACE:g} {y - 4:.1f}h36", colour, dashes, 2.0)
        yield _text(SPACE + 46, y, name)
    yield _text(SPACE, top + len(rows) * LINE, "x up and y to the left, m", "small")


def _text(x: float, y: float, text: str, style: str = "") -> str:
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{html.escape(text)}</text>'
