"""What a drawing tells: ports, values, wires of each kind, subgraphs, findings; and what it never does."""

from __future__ import annotations

import re
from itertools import pairwise
from xml.etree import ElementTree

import pytest

from tests.cli.harness import ROOT
from tests.drawing.conftest import Draw
from tests.drawing.reading import NAMESPACE, Drawing, Point, Text, mistakes, read

CMD_VEL = (ROOT / "graphs/tutorial/cmd_vel.yaml").read_text(encoding="utf-8")
TICK = "graph: mine\nnodes:\n  Tick: OnPlaybackTick\n"


def nodes(text: str) -> dict[str, ElementTree.Element]:
    """Elements of the nodes by their names."""
    found = ElementTree.fromstring(text).iter(f"{NAMESPACE}g")
    return {words(node, "name"): node for node in found if "node" in node.attrib.get("class", "").split()}


def groups(of: ElementTree.Element, kind: str) -> list[ElementTree.Element]:
    return [group for group in of.iter(f"{NAMESPACE}g") if group.get("class") == kind]


def words(node: ElementTree.Element, kind: str) -> str:
    return next("".join(text.itertext()) for text in node.iter(f"{NAMESPACE}text") if text.get("class") == kind)


def told(node: ElementTree.Element) -> str:
    return node.findtext(f"{NAMESPACE}title") or ""


def ports(node: ElementTree.Element) -> dict[str, str]:
    """What is told of each port, by what is written on it."""
    texts = ((group.find(f"{NAMESPACE}text"), group) for group in groups(node, "port"))
    return {"".join(text.itertext()): told(group) for text, group in texts if text is not None}


def label(drawing: Drawing, node: str, port: str) -> tuple[Text, tuple[float, float, float, float]]:
    """A port's text and the box that it is in."""
    box = next(box for text, box in drawing.texts if text.text == node and text.bold and box)
    return next(text for text, within in drawing.texts if within == box and text.text.split()[0] == port), box


def failed(made: dict[str, ElementTree.Element]) -> list[str]:
    """Names of the nodes that are drawn with an error."""
    return [name for name, node in made.items() if "error" in node.attrib["class"].split()]


def test_each_wire_runs_from_the_height_of_one_port_to_that_of_another(drawn: Draw) -> None:
    drawing = read(drawn(CMD_VEL))
    assert len(drawing.wires) == 10
    for about, points in drawing.wires:
        for end, place, side in zip(about.split(" -> "), (points[0], points[-1]), (2, 0), strict=True):
            text, box = label(drawing, *end.split("."))
            assert abs(place[0] - box[side]) < 10.5  # px, an arrow head
            assert abs(place[1] + 4 - text.y) < 0.3


def test_set_values_are_drawn_with_units_and_in_full_in_the_tooltip(drawn: Draw) -> None:
    made = nodes(drawn(CMD_VEL))
    shown = ports(made["DiffController"])
    assert "wheelRadius 0.1 m" in shown
    assert shown["wheelRadius 0.1 m"].startswith("wheelRadius: double, m\ndefault 0.0")
    (joints,) = [about for text, about in ports(made["ArtController"]).items() if text.startswith("jointNames")]
    assert "set to [front_left_wheel_joint, front_right_wheel_joint]" in joints
    assert "wheelDistance 0.45 m" in shown
    assert not any(text.startswith("maxWheelSpeed") for text in shown)  # neither set nor wired


def test_execution_value_and_later_wires_have_different_styles(drawn: Draw) -> None:
    wires = "[Tick.tick -> Wait.execIn, Wait.finished -> Clock.execIn, Tick.time -> Clock.timeStamp]"
    clock = "Clock: {type: PublishClock, inputs: {topicName: c}}"
    text = drawn(f"{TICK}  Wait: Delay\n  {clock}\nconnections: {wires}\n")
    drawn_wires = groups(ElementTree.fromstring(text), "connection")
    styles = {told(group): [path.get("class") for path in group.iter(f"{NAMESPACE}path")] for group in drawn_wires}
    assert styles == {
        "Tick.tick -> Wait.execIn": ["wire exec", "exec-tip"],
        "Wait.finished -> Clock.execIn": ["wire later", "exec-tip"],
        "Tick.time -> Clock.timeStamp": ["wire data-wire", "data-tip"],
    }
    widths = dict(re.findall(r"(exec|data-wire)\b[^{]*\{[^}]*stroke-width: ([\d.]+)", text))
    assert float(widths["exec"]) >= 2 * float(widths["data-wire"])


def test_findings_are_drawn_on_their_nodes(drawn: Draw) -> None:
    made = nodes(
        drawn(
            f"{TICK}  Odd: {{type: NoSuchType, inputs: {{x: 1}}}}\n"
            "  Clock: {type: PublishClock, inputs: {topicName: clock, queueSize: -1}}\n"
            "connections: [Tick.tick -> Clock.execIn, Tick.time -> Clock.nothing]\n"
        )
    )
    assert failed(made) == ["Odd", "Clock"]
    assert "error G201: unknown node type 'NoSuchType'" in told(made["Odd"])
    assert "error G212: Clock.queueSize: expected" in told(made["Clock"])
    assert "error G204: ROS2PublishClock has no input 'nothing'" in told(made["Clock"])
    texts = made["Clock"].iter(f"{NAMESPACE}text")
    assert [text.text for text in texts if "mark" in text.get("class", "")] == [
        "error G204",
        "error G212",
        "warning W213",
    ]
    assert "error" not in told(made["Tick"])


def test_a_wrong_value_of_a_parameter_is_painted_on_the_node_that_uses_it(drawn: Draw) -> None:
    part = (
        "graph: part\nparameters: {size: {type: any, default: 1}}\ninputs: {go: Clock.execIn}\nnodes:\n"
        "  Clock: {type: PublishClock, inputs: {topicName: clock, queueSize: $(size)}}\n"
    )
    use = "  Part: {subgraph: part.yaml, parameters: {size: -1}}\nconnections: [Tick.tick -> Part.go]\n"
    assert failed(nodes(drawn(f"{TICK}{use}", part=part))) == ["Clock"]


def test_a_warning_is_drawn_in_the_style_of_warnings(drawn: Draw) -> None:
    made = nodes(drawn(f"{TICK}  Idle: {{type: Counter}}\n"))
    assert made["Idle"].attrib["class"].split() == ["node", "action", "warning"]
    assert "warning W101: no event reaches Idle" in told(made["Idle"])


def test_the_error_of_a_wire_to_a_missing_node_is_drawn_at_its_other_node(drawn: Draw) -> None:
    made = nodes(drawn(f"{TICK}connections: [Tick.tick -> Nobody.execIn]\n"))
    assert "error G203: no node 'Nobody'" in told(made["Tick"])


def test_the_rate_of_a_node_is_drawn_on_its_box(drawn: Draw) -> None:
    made = nodes(drawn("graph: mine\nnodes:\n  Tick: {type: OnPlaybackTick, every: {hz: 2.5}}\n"))
    assert words(made["Tick"], "type") == "OnPlaybackTick, every 2.5 Hz"


def test_a_finding_without_a_node_is_drawn_below_the_title(drawn: Draw) -> None:
    text = drawn(f"{TICK}connections: [Tick.tick]\n")
    assert "error G202: a connection has one arrow" in text
    assert mistakes(read(text)) == []


def test_nodes_of_a_subgraph_stand_within_its_border(drawn: Draw) -> None:
    inner = (
        "graph: inner\ninputs: {go: Branch.execIn}\noutputs: {done: Count.execOut}\n"
        "nodes: {Branch: Branch, Count: Counter}\nconnections: [Branch.execTrue -> Count.execIn]\n"
    )
    middle = (
        "graph: middle\ninputs: {}\nnodes: {Tick: OnPlaybackTick, Deep: {subgraph: inner.yaml}}\n"
        "connections: [Tick.tick -> Deep.go]\n"
    )
    text = drawn(
        f"{TICK}  One: {{subgraph: inner.yaml}}\n  Two: {{subgraph: inner.yaml}}\n  Three: {{subgraph: middle.yaml}}\n"
        "connections: [Tick.tick -> One.go, One.done -> Two.go]\n",
        inner=inner,
        middle=middle,
    )
    drawing = read(text)
    assert mistakes(drawing) == []
    assert len(drawing.groups) == 4
    assert sorted(about for about, _ in drawing.wires) == [
        "One/Branch.execTrue -> One/Count.execIn",
        "One/Count.execOut -> Two/Branch.execIn",
        "Three/Deep/Branch.execTrue -> Three/Deep/Count.execIn",
        "Three/Tick.tick -> Three/Deep/Branch.execIn",
        "Tick.tick -> One/Branch.execIn",
        "Two/Branch.execTrue -> Two/Count.execIn",
    ]
    captions = {words.text for words, _ in drawing.texts}
    assert {"One  inner.yaml", "Two  inner.yaml", "Three  middle.yaml", "Deep  inner.yaml"} <= captions


def test_what_a_stranger_writes_is_text(drawn: Draw) -> None:
    evil = '"\\"><script>alert(1)</script>]]><!-- &amp; \\u202e \\x07 onload=x"'
    text = drawn(
        f"{TICK}  Clock: {{type: PublishClock, doc: {evil}, inputs: {{topicName: {evil}}}}}\n  Odd: {{type: {evil}}}\n"
        f"connections: [Tick.tick -> Clock.execIn, {evil}]\n"
    )
    tags = {element.tag.removeprefix(NAMESPACE) for element in ElementTree.fromstring(text).iter()}
    assert tags == {"svg", "title", "style", "g", "rect", "path", "text", "tspan"}
    attributes = {name for element in ElementTree.fromstring(text).iter() for name in element.attrib}
    assert not any(name.startswith("on") or "href" in name for name in attributes)
    assert "\u202e" not in text
    assert "alert(1)" in text


def test_positions_in_the_file_keep_their_arrangement(drawn: Draw) -> None:
    names = ["Tick", "A", "B", "C", "Far"]
    places: list[Point] = [(0, 0), (200, 0), (200, 90), (-150, 300)]
    layout = ", ".join(f"{name}: [{x}, {y}]" for name, (x, y) in zip(names, places, strict=False))
    text = drawn(
        f"{TICK}  A: Counter\n  B: Counter\n  C: Counter\n  Far: Counter\nlayout: {{{layout}, Far: [1.0e+30, 0]}}\n"
        "connections: [Tick.tick -> A.execIn, A.execOut -> B.execIn, B.execOut -> C.execIn, C.execOut -> A.reset]\n"
    )
    drawing = read(text)
    assert mistakes(drawing) == []
    corners = [(box[0], box[1]) for box in drawing.boxes]
    x0, y0 = corners[0]
    stretch = (corners[1][0] - x0) / 200
    assert 1.0 <= stretch <= 6.0
    for (x, y), (u, v) in zip(places[1:], corners[1:4], strict=True):
        assert abs(u - x0 - stretch * x) < 0.5
        assert abs(v - y0 - stretch * y) < 0.5
    assert corners[4][1] > max(corner[1] for corner in corners[:4])  # what has no place stands below


def test_a_graph_of_a_thousand_nodes_is_drawn(drawn: Draw) -> None:
    lines = [f"  N{number}: BooleanNot" for number in range(1000)]
    wires = [f"N{number // 2}.valueOut -> N{number}.valueIn" for number in range(1, 1000)]
    drawing = read(drawn("graph: large\nnodes:\n" + "\n".join(lines) + f"\nconnections: [{', '.join(wires)}]\n"))
    assert len(drawing.boxes) == 1000
    assert len(drawing.wires) == 999


def test_a_graph_without_nodes_is_drawn(drawn: Draw) -> None:
    drawing = read(drawn("graph: empty\n"))
    assert (drawing.boxes, drawing.wires) == ([], [])
    assert mistakes(drawing) == []


CIRCLE = """
graph: circle
nodes:
  Tick: OnPlaybackTick
  Branch: Branch
  First: {type: PrintText, inputs: {text: hi}}
  After: {type: PrintText, inputs: {text: bye}}
connections:
  - Tick.tick -> Branch.execIn
  - Branch.execTrue -> First.execIn
  - First.execOut -> Branch.execIn
  - Branch.execFalse -> After.execIn
"""


def circular(text: str) -> list[str]:
    """What is told of the wires that are drawn as a part of a circle."""
    wires = groups(ElementTree.fromstring(text), "connection")
    return [told(wire) for wire in wires if "circle" in wire[1].attrib["class"].split()]


def test_a_graph_that_runs_in_a_circle_is_drawn_with_the_circle_on_it(drawn: Draw) -> None:
    text = drawn(CIRCLE)
    assert circular(text) == ["Branch.execTrue -> First.execIn", "First.execOut -> Branch.execIn"]
    made = nodes(text)
    assert failed(made) == ["Branch", "First"]
    assert "execution wires form a cycle: Branch -> First -> Branch" in told(made["First"])
    assert "in a circle</text>" in text
    assert mistakes(read(text)) == []


def test_a_circle_of_values_is_drawn_too(drawn: Draw) -> None:
    add = "{type: Add, inputs: {b: {type: double, value: 1}}}"
    wires = "  - A.sum -> B.a\n  - B.sum -> A.a\n  - Tick.time -> C.a\n"
    text = drawn(f"{TICK}  A: {add}\n  B: {add}\n  C: {add}\nconnections:\n{wires}")
    assert failed(nodes(text)) == ["A", "B"]


PART = "graph: part\ninputs: {go: A.execIn}\noutputs: {done: B.execOut}\nnodes:\n  A: {type: PrintText, inputs: {text: a}}\n"
PART += "  B: {type: PrintText, inputs: {text: b}}\nconnections:\n  - A.execOut -> B.execIn\n"
TWICE = f"{TICK}  Good: {{subgraph: part.yaml}}\n  Bad: {{subgraph: part.yaml}}\n"
GO = "  - Tick.tick -> Good.go\n  - Tick.tick -> Bad.go\n"


def test_a_cycle_through_one_of_two_uses_of_a_subgraph_marks_only_this_use(drawn: Draw) -> None:
    text = drawn(f"{TWICE}connections:\n{GO}  - Bad.done -> Bad.go\n", part=PART)
    assert circular(text) == ["Bad/A.execOut -> Bad/B.execIn", "Bad/B.execOut -> Bad/A.execIn"]
    assert text.count("error G210</text>") == 2


def test_a_space_separates_port_and_value_without_css(drawn: Draw) -> None:
    space = "{http://www.w3.org/XML/1998/namespace}space"
    assert ElementTree.fromstring(drawn(TICK)).get(space) == "preserve"


def test_a_link_to_the_left_crosses_no_box(drawn: Draw) -> None:
    wires = f"{GO}  - Bad.done -> P.execIn\n  - P.execOut -> Bad.go\n  - Tick.tick -> P.no\n"
    drawing = read(drawn(f"{TWICE}  P: PrintText\nconnections:\n{wires}", part=PART))
    boxes = {box for _, box in drawing.texts if box}
    for _, points in drawing.wires:
        for (x0, y0), (x1, y1) in pairwise(points):
            for left, top, right, bottom in boxes:
                beside = y0 == y1 and min(x0, x1) < right and max(x0, x1) > left
                assert not (beside and any(abs(y0 - edge) < 5 for edge in (top, bottom)))


def test_a_large_graph_gets_the_linear_layout(drawn: Draw, monkeypatch: pytest.MonkeyPatch) -> None:
    def lay_out(*_: object, **__: object) -> None:
        raise AssertionError("graphlay lays out a large graph")

    monkeypatch.setattr("graphlay.layout", lay_out)
    chain = ["Tick.tick -> N0.execIn", *(f"N{i}.execOut -> N{i + 1}.execIn" for i in range(299))]
    wires = [*chain, *(f"Tick.tick -> N{i}.reset" for i in range(300))]
    counters = "".join(f"  N{i}: Counter\n" for i in range(300))
    text = f"{TICK}{counters}connections:\n" + "".join(f"  - {wire}\n" for wire in wires)
    assert len(nodes(drawn(text))) == 301
