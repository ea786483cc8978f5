"""Reads an SVG back as boxes, lines and texts with places on the page, by an XML parser and the marks of its elements alone."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from xml.etree import ElementTree

from PIL import ImageFont

NAMESPACE = "{http://www.w3.org/2000/svg}"
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
FINE = 1000.0  # px; of a font that is measured without the rounding of small sizes
ARROW = 9.0  # px; length of an arrow head, before which its line ends
SLACK = 0.2  # px; places are written with one decimal

Point = tuple[float, float]
Rectangle = tuple[float, float, float, float]


@dataclass
class Text:
    x: float
    y: float
    text: str
    size: float
    bold: bool
    ends: bool

    def extents(self) -> Iterator[tuple[float, float]]:
        """From where to where it reaches, in the fonts that are at hand."""
        for font in fonts(FINE, self.bold):
            width = font.getlength(self.text) / FINE * self.size
            yield (self.x - width, self.x) if self.ends else (self.x, self.x + width)


@dataclass
class Drawing:
    width: float
    height: float
    boxes: list[Rectangle] = field(default_factory=list)
    groups: list[Rectangle] = field(default_factory=list)
    texts: list[tuple[Text, Rectangle | None]] = field(default_factory=list)
    """Each with the box that it is in."""
    wires: list[tuple[str, list[Point]]] = field(default_factory=list)
    """What is told of each, and its corners."""
    titles: list[str] = field(default_factory=list)


def fonts(size: float, bold: bool) -> Iterator[ImageFont.FreeTypeFont]:
    """DejaVu Sans where it is installed; Aileron, which is as wide as Helvetica, comes with Pillow."""
    with contextlib.suppress(OSError):
        yield ImageFont.truetype("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf", size)
    found = ImageFont.load_default(size)
    assert isinstance(found, ImageFont.FreeTypeFont)
    yield found


def sizes(svg: ElementTree.Element) -> dict[str, float]:
    """Font sizes of the style sheet, by class; `text` is that of all others."""
    style = svg.findtext(f"{NAMESPACE}style") or ""
    found: dict[str, float] = {}
    for selectors, size in re.findall(r"([^{}]+)\{[^{}]*font-size: ([\d.]+)px", style):
        found |= {selector.strip().lstrip("."): float(size) for selector in selectors.split(",")}
    return found


def read(text: str) -> Drawing:
    svg = ElementTree.fromstring(text)
    left, top, width, height = map(float, svg.attrib["viewBox"].split())
    assert (left, top, width, height) == (0, 0, float(svg.attrib["width"]), float(svg.attrib["height"]))
    drawing = Drawing(width, height)
    collect(drawing, svg, (0.0, 0.0), None, sizes(svg))
    return drawing


def collect(
    drawing: Drawing, element: ElementTree.Element, origin: Point, box: Rectangle | None, font: dict[str, float]
) -> None:
    x0, y0 = origin
    if transform := element.attrib.get("transform"):
        moved = re.fullmatch(rf"translate\(({NUMBER}) ({NUMBER})\)", transform)
        assert moved, transform  # nothing is scaled, so a font size is what it says
        x0, y0 = x0 + float(moved[1]), y0 + float(moved[2])
    classes = element.attrib.get("class", "").split()
    if "node" in classes:
        frame = next(rect for rect in element.iter(f"{NAMESPACE}rect") if rect.attrib["class"] == "box")
        within = (x0, y0, x0 + float(frame.attrib["width"]), y0 + float(frame.attrib["height"]))
        drawing.boxes.append(within)
        box = within
    if "group" in classes:
        x, y = x0 + float(element.attrib["x"]), y0 + float(element.attrib["y"])
        drawing.groups.append((x, y, x + float(element.attrib["width"]), y + float(element.attrib["height"])))
    if "connection" in classes:
        path = next(path for path in element.iter(f"{NAMESPACE}path") if "wire" in path.attrib["class"])
        drawing.wires.append((element.findtext(f"{NAMESPACE}title") or "", corners(path.attrib["d"], x0, y0)))
    if element.tag == f"{NAMESPACE}title":
        drawing.titles.append(element.text or "")
    if element.tag == f"{NAMESPACE}text":
        size = next((font[name] for name in classes if name in font), font["text"])
        place = (x0 + float(element.attrib["x"]), y0 + float(element.attrib["y"]))
        bold = bool({"name", "title", "mark"} & set(classes))
        words, ends = "".join(element.itertext()), element.attrib.get("text-anchor") == "end"
        drawing.texts.append((Text(*place, words, size, bold, ends), box))
    for child in element:
        collect(drawing, child, (x0, y0), box, font)


def corners(path: str, x0: float, y0: float) -> list[Point]:
    """Points of a path of straight lines with rounded corners, the tips of the corners among them."""
    points = []
    for command, numbers in re.findall(rf"([MLQ])((?:{NUMBER}[ ]?)+)", path):
        values = [float(number) for number in re.findall(NUMBER, numbers)]
        assert len(values) == (4 if command == "Q" else 2)
        points += [(x0 + values[i], y0 + values[i + 1]) for i in range(0, len(values), 2)]
    return points


def overlap(one: Rectangle, other: Rectangle) -> bool:
    return all(one[i] < other[i + 2] - SLACK and other[i] < one[i + 2] - SLACK for i in (0, 1))


def mistakes(drawing: Drawing) -> list[str]:
    """What makes a drawing hard to read."""
    found = []
    for number, box in enumerate(drawing.boxes):
        found += [f"boxes overlap: {box} {other}" for other in drawing.boxes[:number] if overlap(box, other)]
    for about, points in drawing.wires:
        begins = [box for box in drawing.boxes if on_side(points[0], box, 2, 0.0)]
        ends = [box for box in drawing.boxes if on_side(points[-1], box, 0, -ARROW)]
        if len(begins) != 1 or len(ends) != 1:
            found.append(f"{about} does not run from box to box: {points[0]} {points[-1]}")
        for (x, y), (u, v) in pairwise(points):
            line = (min(x, u), min(y, v), max(x, u), max(y, v))
            found += [f"{about} runs through a box: {line} {box}" for box in drawing.boxes if crosses(line, box)]
            if min(abs(x - u), abs(y - v)) > SLACK:
                found.append(f"{about} runs askew: {line}")
    for text, around in drawing.texts:
        if text.size < 9:
            found.append(f"small: {text}")
        for begin, end in text.extents():
            low, high = (around[0], around[2]) if around else (0.0, drawing.width)
            if begin < low or end > high:
                found.append(f"too wide: {text} {low} {high}")
    for shape in [*drawing.boxes, *drawing.groups, *(span(points) for _, points in drawing.wires)]:
        if shape[0] < 0 or shape[1] < 0 or shape[2] > drawing.width or shape[3] > drawing.height:
            found.append(f"outside: {shape}")
    for number, group in enumerate(drawing.groups):
        for other in drawing.groups[:number]:
            if overlap(group, other) and not (inside(group, other) or inside(other, group)):
                found.append(f"subgraphs overlap: {group} {other}")
        crossed = [box for box in drawing.boxes if overlap(box, group) and not inside(box, group)]
        found += [f"on the border of a subgraph: {box}" for box in crossed]
    return found


def on_side(point: Point, box: Rectangle, side: int, before: float) -> bool:
    """Whether a point lies on the left (0) or right (2) side of a box, or so far before it."""
    return abs(point[0] - box[side] - before) < SLACK and box[1] < point[1] < box[3]


def crosses(line: Rectangle, box: Rectangle) -> bool:
    """Whether a line is within a box, not only along its border; to the corner of a rounded turn it is no farther."""
    x0, y0, x1, y1 = (box[0] + SLACK, box[1] + SLACK, box[2] - SLACK, box[3] - SLACK)
    return line[0] < x1 and line[2] > x0 and line[1] < y1 and line[3] > y0


def span(points: list[Point]) -> Rectangle:
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def inside(one: Rectangle, other: Rectangle) -> bool:
    return other[0] <= one[0] and other[1] <= one[1] and one[2] <= other[2] and one[3] <= other[3]
