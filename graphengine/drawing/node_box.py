"""Computes the size of a node's box, and the positions of its labels and ports."""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.drawing.text_metrics import fitted, width
from graphengine.drawing.view_model import Key, NodeView, PortView
from graphengine.format.diagnostics import Finding

NAME_SIZE, TYPE_SIZE, PORT_SIZE = 13.0, 12.0, 12.0
"""Font sizes, px."""
HEAD, ROW, FOOT = 40.0, 20.0, 7.0
"""Heights of the head of a box, of a line of ports, and of the space at the bottom, px."""
MARGIN = 12.0
"""Distance between a side of the box and the texts of ports, px."""

_BETWEEN = 18.0
"""Minimum distance between the texts of two ports on one line, px."""
_NAME_LIMIT, _PORT_LIMIT, _VALUE_LIMIT = 260.0, 200.0, 126.0
_MARKS = 4
"""Maximum number of lines for findings on a box; the tooltip contains all findings."""


@dataclass(frozen=True, slots=True)
class Label:
    """The name and value of a port, drawn beside the port."""

    view: PortView
    side: str
    y: float
    """Distance of the port from the top of the box, px."""
    name: str
    value: str


@dataclass(frozen=True, slots=True)
class Mark:
    """A line on a box for all findings of the node with the same code."""

    severity: str
    text: str
    about: str
    y: float


@dataclass(frozen=True, slots=True)
class NodeBox:
    """The box of a node: its size, and the texts and positions of its labels, findings and ports."""

    view: NodeView
    width: float
    height: float
    name: str
    type_name: str
    labels: tuple[Label, ...]
    marks: tuple[Mark, ...]
    heights: dict[Key, float]
    """A dict from ports to their distances from the top of the box, px."""

    @property
    def severity(self) -> str:
        """Highest severity of the node's findings: `error`, `warning` or empty."""
        severities = {mark.severity for mark in self.marks}
        return "error" if "error" in severities else "warning" if severities else ""


def make_box(view: NodeView) -> NodeBox:
    """Return the box of a node, with its size and the positions of labels and ports, px."""
    name = fitted(view.name, NAME_SIZE, _NAME_LIMIT, bold=True)
    kind = view.type_name.rpartition(".")[2] or "?"
    type_name = fitted(f"{kind}, {view.pace}" if view.pace else kind, TYPE_SIZE, _NAME_LIMIT)
    wide = max(width(name, NAME_SIZE, bold=True), width(type_name, TYPE_SIZE)) + 2 * MARGIN
    labels: list[Label] = []
    for side in ("left", "right"):
        shown = [port for (at, _), port in view.ports.items() if at == side]
        labels += [_label(port, side, HEAD + ROW * (row + 0.5)) for row, port in enumerate(shown)]
    rows: dict[float, float] = {}
    for label in labels:
        text = f"{label.name} {label.value}" if label.value else label.name
        rows[label.y] = rows.get(label.y, 0.0) + width(text, PORT_SIZE) + MARGIN + _BETWEEN / 2
    marks = _marks(view.findings, HEAD + ROW * len(rows))
    wide = max([wide, *rows.values(), *(width(mark.text, TYPE_SIZE, bold=True) + 2 * MARGIN for mark in marks)])
    heights = {(label.side, label.view.name): label.y for label in labels}
    high = HEAD + ROW * (len(rows) + len(marks)) + (FOOT if rows or marks else 0.0)
    return NodeBox(view, round(wide + 0.5), high, name, type_name, tuple(labels), marks, heights)


def _label(port: PortView, side: str, y: float) -> Label:
    name = fitted(port.name, PORT_SIZE, _PORT_LIMIT)
    value = fitted(port.value, PORT_SIZE, _VALUE_LIMIT, tail=port.is_path) if port.value else ""
    return Label(port, side, y, name, value)


def _marks(findings: list[Finding], top: float) -> tuple[Mark, ...]:
    """Return a line for each finding code, errors first."""
    codes: dict[tuple[bool, str], list[Finding]] = {}
    for finding in findings:
        codes.setdefault((finding.severity != "error", finding.code), []).append(finding)
    lines = []
    for (_, code), same in sorted(codes.items())[:_MARKS]:
        times = f", {len(same)} times" if len(same) > 1 else ""
        about = "\n\n".join("\n".join((finding.message, *finding.help)) for finding in same)
        lines.append((same[0].severity, f"{same[0].severity} {code}{times}", about))
    return tuple(Mark(*line, top + ROW * (row + 0.5)) for row, line in enumerate(lines))
