"""Graph files of recorded graphs: what they say when they are read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.yaml_text import block, flow, scalar
from graphengine.isaac.graph_file import file_names
from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode, RecordedValue, RecordedWire
from tests.isaac.harness import composed, graph, resolved

ODD = ["no", "true", "Null", "1e3", "0x1f", "12:30:00", "~", "-", "- a", "a: b", "#x", "/a/b", "$(x)", "$$", "a #b"]
ODD += [".inf"]
TEXTS = st.text(st.characters(codec="utf-8"), max_size=20) | st.sampled_from(ODD)
KEYS = TEXTS.filter(lambda key: key != "<<")
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**64) | st.floats(allow_nan=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=12,
)


def dollars(value: Any) -> Any:
    """With `$$` read as `$`, as a graph file's values are."""
    if isinstance(value, dict):
        return {key: dollars(item) for key, item in value.items()}
    if isinstance(value, list):
        return [dollars(item) for item in value]
    return value.replace("$$", "$") if isinstance(value, str) else value


def reads(text: str) -> Any:
    """What a graph file reads of the value of a key."""
    findings = Findings()
    read = document.parse(f"key: {text}\n", "test", findings)
    assert findings.items == []
    assert read is not None
    return dollars(read.data["key"])


@given(VALUES)
def test_what_is_written_is_read(value: Any) -> None:
    found = reads(flow(value))
    assert found == value
    assert type(found) is type(value)


LINES = st.text(st.sampled_from(" \t#'\"\\:$-|>%&*!é\u2028\r{}[]ab"), max_size=6)


@given(st.lists(LINES, min_size=1, max_size=6).map("\n".join))
def test_a_text_of_several_lines_is_read_as_it_was(text: str) -> None:
    first, *lines = block(text) or [flow(text)]
    assert reads("\n".join([first, *(f"  {line}" if line else "" for line in lines)])) == text


def test_a_script_is_written_as_a_block() -> None:
    assert block("def f():\n\n    pass # $x\n") == ["|", "def f():", "", "    pass # $$x"]
    assert block("one line") == []


def test_numbers_that_are_none_are_written_as_yaml_has_them() -> None:
    assert [scalar(float(text)) for text in ("nan", "inf", "-inf")] == [".nan", ".inf", "-.inf"]


def written(recorded: RecordedGraph, folder: Path) -> tuple[Path, list[str]]:
    text, findings = composed(recorded)
    (folder / "g.yaml").write_text(text, encoding="utf-8")
    return folder / "g.yaml", [f"{finding.code} {finding.message}" for finding in findings.items]


def test_graphs_of_one_name_get_names_of_their_own() -> None:
    paths = ["/World/a/drive", "/World/b/drive", "/World/b/Drive", "/World/a-b/c d", "/", "/World/a/drive/"]
    names = file_names([RecordedGraph(path) for path in paths])
    assert names == ["drive", "b_drive", "World_b_Drive", "c_d", "_", "a_drive"]
    assert len({name.lower() for name in names}) == len(paths)


@pytest.mark.parametrize(
    ("node", "message"),
    [
        (RecordedNode("n", "OnTick", {"inputs:speed": RecordedValue(1)}), "n.inputs:speed: OnTick has no such input"),
        (
            RecordedNode("n", "OnTick", {"outputs:time": RecordedValue(1)}),
            "a graph file contains values of inputs only",
        ),
        (RecordedNode("n", "x.y", {"inputs:a b": RecordedValue(1)}), "it is not a legal port name"),
        (RecordedNode("n", "x.y", {"inputs:a": RecordedValue(None)}), "it is None"),
    ],
)
def test_a_value_that_no_file_holds_is_left_out(node: RecordedNode, message: str, tmp_path: Path) -> None:
    path, told = written(graph(node), tmp_path)
    assert message in told[-1]
    assert resolved(path)[0].flat.spec.nodes["n"].inputs == {}


def test_how_to_let_an_impulse_fire_is_told(tmp_path: Path) -> None:
    node = RecordedNode("On Impulse", "OnImpulseEvent", {"state:enableImpulse": RecordedValue(True)})
    _, findings = composed(graph(node))
    assert findings.warnings[0].help == ("at run time: graphrun ctl impulse On_Impulse",)


def test_a_node_without_a_type_is_left_out_with_its_wires(tmp_path: Path) -> None:
    nodes = RecordedNode("a", "OnTick"), RecordedNode("b", "", position=(1.0, 2.0))
    path, told = written(graph(*nodes, wires=[RecordedWire("a", "outputs:tick", "b", "inputs:execIn")]), tmp_path)
    assert told == [
        "W302 the node /World/g/b is left out: it has no type",
        "W302 /World/g: not converted: the wire a.outputs:tick -> b.inputs:execIn: there is no node 'b'",
    ]
    assert list(resolved(path)[0].flat.spec.nodes) == ["a"]


def test_a_wire_to_what_is_not_there_is_left_out(tmp_path: Path) -> None:
    nodes = RecordedNode("a", "OnTick"), RecordedNode("b", "Counter")
    ends = [("b", "inputs:exec"), ("c", "inputs:execIn"), ("b", "inputs:execIn"), ("b", "inputs:execIn")]
    wires = [RecordedWire("a", "outputs:tick", *end) for end in ends]
    path, told = written(graph(*nodes, wires=wires), tmp_path)
    assert [line.partition(": not converted: ")[2] for line in told] == [
        "the wire a.outputs:tick -> b.inputs:exec: Counter has no inputs:exec",
        "the wire a.outputs:tick -> c.inputs:execIn: there is no node 'c'",
    ]
    assert [str(wire) for wire in resolved(path)[0].exec_wires] == ["a.tick -> b.execIn"]


def test_a_side_is_written_where_a_port_stands_on_both(tmp_path: Path) -> None:
    nodes = RecordedNode("w", "omni.graph.core.WriteVariable"), RecordedNode("v", "omni.graph.core.WriteVariable")
    wires = [RecordedWire("w", "inputs:variableName", "v", "inputs:variableName")]
    wires += [RecordedWire("w", "inputs:value", "v", "inputs:value")]
    path, _ = written(graph(*nodes, wires=wires), tmp_path)
    assert "  - w.inputs:value -> v.value\n" in path.read_text(encoding="utf-8")
    assert "  - w.variableName -> v.variableName\n" in path.read_text(encoding="utf-8")


def test_a_lazy_graph_becomes_a_push_graph_and_that_is_told(tmp_path: Path) -> None:
    recorded = graph(RecordedNode("n", "OnTick"))
    recorded.evaluator = "dirty_push"
    path, told = written(recorded, tmp_path)
    assert resolved(path)[0].flat.spec.evaluator == "push"
    assert any("every node is computed, not only changed ones" in line for line in told)


def test_a_stage_that_there_is_not_here_is_told(tmp_path: Path) -> None:
    recorded = graph(RecordedNode("n", "OnTick"))
    recorded.pipeline_stage = "post_render"
    _, told = written(recorded, tmp_path)
    assert told == ["W302 /World/g: not converted: the pipeline stage post_render; the graph runs every tick"]


def test_inputs_that_pass_events_on_to_each_other_in_many_ways_are_followed_in_bounded_time() -> None:
    branch, tick = "omni.graph.action.Branch", "omni.graph.action.OnPlaybackTick"
    nodes = [RecordedNode("Tick", tick), *(RecordedNode(f"{side}{n}", branch) for n in range(100) for side in "ab")]
    ends = [(f"{source}{n}", f"{target}{n + 1}") for n in range(99) for source in "ab" for target in "ab"]
    passing = [RecordedWire(source, "inputs:execIn", target, "inputs:execIn") for source, target in ends]
    wires = [RecordedWire("Tick", "outputs:tick", "a0", "inputs:execIn"), *passing]
    text, findings = composed(graph(*nodes, wires=wires))
    assert text.count("Tick.tick -> ") == 1 + 2 * 99
    lost = {f"the wire b0.inputs:execIn -> {side}1.inputs:execIn: no output fires b0.inputs:execIn" for side in "ab"}
    assert {finding.message.partition(": not converted: ")[2] for finding in findings.warnings} == lost


def test_an_attribute_that_a_script_node_cannot_have_is_told_and_left_out() -> None:
    attributes = {"inputs:all": "bundle", "inputs:a:b": "double", "inputs:go": "execution", "outputs:out": "any"}
    text, findings = composed(graph(RecordedNode("S", "omni.graph.scriptnode.ScriptNode", attributes=attributes)))
    assert 'attributes: ["inputs:go execution", "outputs:out any"]' in text
    assert [finding.code for finding in findings.items] == ["W302", "W302"]
    assert "'inputs:all bundle': a script cannot have a bundle" in findings.items[0].message
    assert "'inputs:a:b double' declares no attribute" in findings.items[1].message


def test_modules_of_omniverse_in_the_script_of_a_node_are_told() -> None:
    code = (
        "import math\nimport omni.graph.core as og\ndef compute(db):\n    from pxr import Gf\n    db.outputs.out = 1\n"
    )
    values = {"inputs:script": RecordedValue(code)}
    _, findings = composed(graph(RecordedNode("S", "omni.graph.scriptnode.ScriptNode", values)))
    assert [(finding.code, finding.message) for finding in findings.items] == [
        ("W302", "S: its script imports omni.graph.core, pxr, which do not exist in graphengine")
    ]
    fine = {"inputs:script": RecordedValue("import omnibus, math\nx = 'import omni'\n")}
    assert composed(graph(RecordedNode("S", "omni.graph.scriptnode.ScriptNode", fine)))[1].items == []
