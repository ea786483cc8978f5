"""What makes a drawing readable holds for all that ships, and for any graph."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from graphengine.drawing import svg
from graphengine.drawing.view_model import make_graph_view
from graphengine.scene import build
from tests.cli.harness import GRAPHS, ROOT
from tests.drawing.reading import mistakes, read
from tests.other_process import in_another_process

TYPES = ["OnPlaybackTick", "Branch", "Counter", "Delay", "ROS2PublishClock", "ROS2PublishOdometry", "BooleanNot"]
TYPES += ["Nothing"]
INPUTS = ["execIn", "condition", "reset", "duration", "timeStamp", "position", "valueIn", "nothing"]
OUTPUTS = ["tick", "execTrue", "execFalse", "execOut", "count", "finished", "valueOut", "time", "nothing"]
OUTPUTS += ["inputs:valueIn"]
PART = """graph: part
inputs: {go: Branch.execIn, condition: Not.valueIn}
outputs: {done: Count.execOut, value: Not.valueOut}
nodes: {Branch: Branch, Not: BooleanNot, Count: Counter}
connections: [Branch.execTrue -> Count.execIn, Not.valueOut -> Branch.condition]
"""
TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=60)


def drawn(path: Path) -> str:
    assembly = build.load(path)
    return svg.draw([make_graph_view(graph, assembly.findings) for graph in assembly.planned])


@pytest.mark.parametrize("name", GRAPHS)
def test_graphs_that_ship_are_readable(name: str) -> None:
    drawing = read(drawn(ROOT / "graphs" / f"{name}.yaml"))
    data = yaml.safe_load((ROOT / "graphs" / f"{name}.yaml").read_text(encoding="utf-8"))
    assert mistakes(drawing) == []
    texts = {text.text for text, _ in drawing.texts}
    parts = {name for name, node in data["nodes"].items() if "subgraph" in node}
    assert texts >= set(data["nodes"]) - parts
    if parts:  # drawn with the nodes and wires in them
        assert len(drawing.boxes) > len(data["nodes"])
        return
    assert len(drawing.boxes) == len(data["nodes"])
    assert sorted(about for about, _ in drawing.wires) == sorted(data["connections"])


@st.composite
def graphs(draw: st.DrawFn) -> dict[str, object]:
    """Graph files with wires that make sense and others, cycles, values of all lengths, places for some of the nodes."""
    names = [
        f"{draw(st.sampled_from(['N', 'aVeryLongNameOfANode_']))}{number}" for number in range(draw(st.integers(1, 14)))
    ]
    values = st.dictionaries(st.sampled_from([*INPUTS, "topicName", "frameId"]), TEXTS, max_size=3)
    nodes: dict[str, object] = {name: {"type": draw(st.sampled_from(TYPES)), "inputs": draw(values)} for name in names}
    parts = [f"Part{number}" for number in range(draw(st.integers(0, 2)))]
    begin = st.tuples(st.sampled_from(names), st.sampled_from(OUTPUTS))
    end = st.tuples(st.sampled_from(names), st.sampled_from(INPUTS))
    if parts:
        begin |= st.tuples(st.sampled_from(parts), st.sampled_from(["done", "value"]))
        end |= st.tuples(st.sampled_from(parts), st.sampled_from(["go", "condition"]))
    wires = draw(st.lists(st.tuples(begin, end), max_size=30))
    connections = [f"{'.'.join(source)} -> {'.'.join(target)}" for source, target in wires]
    place = st.tuples(st.integers(-300, 900), st.integers(-300, 900)).map(list)
    layout = draw(st.dictionaries(st.sampled_from([*names, *parts]), place)) if draw(st.booleans()) else {}
    nodes |= {name: {"subgraph": "part.yaml"} for name in parts}
    return {"graph": "any", "nodes": nodes, "connections": connections, "layout": layout}


STRETCHED = {  # by a factor that no two sums round alike
    "graph": "any",
    "nodes": {f"N{number}": "OnPlaybackTick" for number in range(7)},
    "connections": ["N2.execTrue -> N2.execIn"],
    "layout": {"N0": [0, 0], "N1": [72, 0], "N2": [-198, 0]},
}


@given(graphs())
@example(STRETCHED)
@settings(max_examples=60)
def test_any_graph_is_readable(data: dict[str, object]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "any.yaml"
        path.with_name("part.yaml").write_text(PART, encoding="utf-8")
        path.write_text(yaml.safe_dump(data, allow_unicode=False), encoding="utf-8")
        assert mistakes(read(drawn(path))) == []


def test_a_graph_is_drawn_alike_in_another_process(tmp_path: Path) -> None:
    path = tmp_path / "any.yaml"
    path.write_text(yaml.safe_dump(STRETCHED), encoding="utf-8")
    assert in_another_process(drawn, path) == drawn(path)
