"""Calls of `omni.graph.core`, `pxr` and `usdrt` one by one: what a graph has of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler.registry import default_registry
from graphengine.format.diagnostics import Finding, Findings
from graphengine.isaac.graph_file import compose
from graphengine.isaac.omniverse.og_types import AttributeRole, BaseDataType, Type
from graphengine.isaac.recorded_graph import RecordedGraph
from graphengine.isaac.script.script_reader import read_script
from tests.isaac.harness import read_text

START = (
    "import math, numpy as np, omni.graph.core as og, usdrt.Sdf\n"
    "from pxr import Gf, Sdf, Vt\n"
    'graph, (a, b), _, _ = og.Controller.edit("/g", {"create_nodes": [("a", "x.A"), ("b", "x.B")]})\n'
)


def built(folder: Path, text: str) -> tuple[RecordedGraph, list[str]]:
    (graph,), _, findings = read_text(folder, START + text)
    return graph, [finding.message for finding in findings.warnings]


@pytest.mark.parametrize(
    ("written", "data"),
    [
        ("Gf.Vec3d(0.5)", [0.5, 0.5, 0.5]),
        ("Gf.Vec3d(1, 2, 3) + Gf.Vec3d(0.5)", [1.5, 2.5, 3.5]),
        ("Gf.Vec2f()", [0.0, 0.0]),
        ("Gf.Vec4d(np.array([1.0, 2.0, 3.0, 4.0]))", [1.0, 2.0, 3.0, 4.0]),
        ("2 * Gf.Vec2d(1, 2)", [2, 4]),
        ("Gf.Vec3d(1, 2, 3) * Gf.Vec3d(1, 0, 2)", 7),
        ("Gf.Vec3d(3, 0, 4).GetLength()", 5.0),
        ("Gf.Quatd(1, 0, 0, 0)", [0, 0, 0, 1]),
        ("Gf.Matrix2d()", [[1.0, 0.0], [0.0, 1.0]]),
        ("Gf.Matrix2d(np.array([[1.0, 2.0], [3.0, 4.0]]))", [[1.0, 2.0], [3.0, 4.0]]),
        ("Gf.Matrix2d(1, 2, 3, 4)", [[1, 2], [3, 4]]),
        ("Gf.Matrix3d(2).SetIdentity()", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        ('Vt.TokenArray(["a", "b"])', ["a", "b"]),
        ('Sdf.Path("/World/a").GetParentPath().AppendChild("b")', "/World/b"),
        ('usdrt.Sdf.Path("/World/a").GetString()', "/World/a"),
        ('Sdf.Path("/World/a").ReplaceName("c")', "/World/c"),
        ('Sdf.Path("/World/a").HasPrefix("/World")', True),
        ('Sdf.Path("/World/ab").HasPrefix("/World/a")', False),
        ('Sdf.Path.IsValidPathString("/World")', True),
        ("np.float32(0.5)", 0.5),
        ("[math.inf, True, None]", [float("inf"), True, None]),
    ],
)
def test_a_value_arrives(written: str, data: Any, tmp_path: Path) -> None:
    graph, told = built(tmp_path, f"og.Controller.set(a.get_attribute('inputs:x'), {written})")
    assert (graph.nodes["a"].values["inputs:x"].data, told) == (data, [])


@pytest.mark.parametrize("stage", ["SIMULATION", "PRERENDER", "POSTRENDER", "ONDEMAND"])
def test_a_graph_has_the_pipeline_stage_that_it_was_given(stage: str, tmp_path: Path) -> None:
    text = f"stage = og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_{stage}\ngraph.change_pipeline_stage(stage)\n"
    graph, _ = built(tmp_path, f"{text}a.get_attribute('inputs:x').set(graph.get_pipeline_stage() == stage)")
    assert graph.nodes["a"].values["inputs:x"].data is True


@pytest.mark.parametrize(
    "call",
    [
        "og.Controller.connect('/g/a.outputs:o', '/g/b.inputs:i')",
        "og.Controller.connect('/g/a/outputs:o', '/g/b/inputs:i')",
        "og.Controller.connect(('outputs:o', a), ('inputs:i', 'b', graph))",
        "og.Controller.edit(graph, {'connect': ('a.outputs:o', 'b.inputs:i')})",
        "og.Controller.edit(graph, {'connect': ('a.outputs_o', 'b.inputs:i')})",
        "a.get_attribute('outputs_o').connect(b.get_attribute('inputs:i'), True)",
        "b.get_attribute('inputs:i').is_connected(b) or og.GraphController().connect('/g/a.outputs:o', '/g/b.inputs:i')",
    ],
)
def test_a_wire_is_made_by(call: str, tmp_path: Path) -> None:
    graph, told = built(tmp_path, call.replace("is_connected(b)", "is_connected(a.get_attribute('outputs:o'))"))
    assert ([str(wire) for wire in graph.wires], told) == (["a.outputs:o -> b.inputs:i"], [])


def test_two_handles_to_one_attribute_are_equal(tmp_path: Path) -> None:
    text = "one, same, other = (a.get_attribute(f'inputs:{name}') for name in 'xxy')\n"
    graph, _ = built(tmp_path, f"{text}one.set([one == same, hash(one) == hash(same), one == other, one == a])")
    assert graph.nodes["a"].values["inputs:x"].data == [True, True, False, False]


X = "og.Controller.set(a.get_attribute('inputs:x'), {})"
KIND = "a.get_attribute('outputs:o').get_resolved_type()"
EDIT = "og.Controller.edit(og.made_up.graph, {'create_nodes': ('c', 'x.C')})"
LEFT = "on graphs is left out"
FROM = "it comes from"


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (
            "og.cmds.SetAttr(attr=a.get_attribute('inputs:x'), value=1)",
            f"the effect of omni.graph.core.cmds.SetAttr() {LEFT}",
        ),
        ("og.Controller.expose_prim(1, 2)", f"the effect of omni.graph.core.Controller.expose_prim() {LEFT}"),
        ("graph.make_it_so()", f"the effect of og.Graph.make_it_so() {LEFT}"),
        (f"graph.create_variable('v', {KIND})", "the type of variable 'v' is left out"),
        ("a.create_attribute('inputs:n', og.made_up)", f"of a.inputs:n is left out: {FROM} omni.graph.core.made_up"),
        (X.format("Gf.Rotation().GetQuat()"), f"{FROM} pxr.Gf.Rotation().GetQuat()"),
        (X.format("og.made_up.name + '/end'"), "it contains '<unknown: omni.graph.core.made_up.name>/end'"),
        (EDIT, "an edit of <unknown: omni.graph.core.made_up.graph> is left out"),
    ],
    ids=lambda text: text[:30],
)
def test_what_a_graph_lacks_is_told(call: str, told: str, tmp_path: Path) -> None:
    graph, warnings = built(tmp_path, call)
    assert len(warnings) == 1
    assert told in warnings[0]
    assert not graph.variables
    assert not any(node.values or node.attributes for node in graph.nodes.values())


def refused(folder: Path, text: str) -> list[Finding]:
    """The findings of a script that gives no graph."""
    (folder / "script.py").write_text(text, encoding="utf-8")
    findings = Findings()
    assert read_script(folder / "script.py", findings) == []
    return findings.items


def test_an_asset_s_graph_alone_is_told_with_what_to_do(tmp_path: Path) -> None:
    text = "import omni.graph.core as og\nog.Controller.set(og.Controller.attribute('/World/Carter/tf.inputs:x'), 1)"
    (finding,) = refused(tmp_path, text)
    assert finding.message == "OmniGraphError: no graph contains the node '/World/Carter/tf'"
    assert finding.help == ("a USD file that the script opens may contain it; import that file too",)


def test_a_file_of_omniverse_is_only_named(tmp_path: Path) -> None:
    text = "import os\nfrom isaacsim.core.utils.extensions import get_extension_path_from_name as place\n"
    text += "og.Controller.set(a.get_attribute('inputs:x'), os.path.join(place('omni.x'), 'data'))"
    _, (told,) = built(tmp_path, text)
    assert "it contains '<unknown: isaacsim.core.utils.extensions.get_extension_path_from_name()>/data'" in told


def test_a_bad_name_in_a_graph_of_the_script_is_a_mistake(tmp_path: Path) -> None:
    (finding,) = refused(tmp_path, f"{START}og.Controller.node('/g/c')")
    assert finding.message == "OmniGraphError: no node 'c' in /g; nodes: a, b"


@pytest.mark.parametrize(
    ("parts", "name"),
    [
        ((BaseDataType.DOUBLE,), "double"),
        ((BaseDataType.TOKEN, 1, 1), "token[]"),
        ((BaseDataType.FLOAT, 3, 0, AttributeRole.COLOR), "colorf[3]"),
        ((BaseDataType.DOUBLE, 4, 1, AttributeRole.QUATERNION), "quatd[4][]"),
        ((BaseDataType.DOUBLE, 16, 0, AttributeRole.MATRIX), "matrixd[4]"),
        ((BaseDataType.UCHAR, 1, 1, AttributeRole.TEXT), "string"),
        ((BaseDataType.RELATIONSHIP, 1, 0, AttributeRole.TARGET), "target"),
        ((BaseDataType.UINT, 1, 0, AttributeRole.EXECUTION), "execution"),
    ],
)
def test_a_type_has_the_name_that_ogn_files_give_it(parts: tuple[Any, ...], name: str) -> None:
    assert Type(*parts).get_ogn_type_name() == name


COMPOUND = """
box = {
    "create_nodes": [(name, "isaacsim.ros2.bridge.ROS2PublishClock") for name in "ab"],
    "promote_attributes": [("a.inputs:execIn", "inputs:execIn"), ("a.inputs:timeStamp", "inputs:timeStamp")],
}
outer = {
    "create_nodes": ("box", box),
    "promote_attributes": ("box.inputs:execIn", "inputs:execIn"),
    "connect": [("box.inputs:execIn", "b.inputs:execIn"), ("box.inputs:timeStamp", "b.inputs:timeStamp")],
}
nodes = [("tick", "omni.graph.action.OnPlaybackTick"), ("outer", outer)]
og.Controller.edit("/g", {"create_nodes": nodes, "connect": WIRES})
"""
"""A compound in a compound: `b` is called by its short name, and has the events and the time of an input of its compound."""
A_EXEC = "outer/box/a.inputs:execIn"


@pytest.mark.parametrize(
    ("wires", "drives", "lost"),
    [
        ("('tick.outputs:tick', 'outer.inputs:execIn')", ["tick.tick -> outer_box_b.execIn"], []),
        ("[]", [], [f"{A_EXEC} -> outer/box/b.inputs:execIn: no output fires {A_EXEC}"]),
    ],
)
def test_an_input_of_a_compound_drives_what_it_is_wired_to(
    wires: str, drives: list[str], lost: list[str], tmp_path: Path
) -> None:
    graph, told = built(tmp_path, COMPOUND.replace("WIRES", wires))
    assert told == []
    findings = Findings()
    text = compose(graph, "g", default_registry(), findings, "a test")
    data = ["outer_box_a.timeStamp -> outer_box_b.timeStamp"]
    targets = [line.strip("- ") for line in text.splitlines() if "outer_box_b." in line]
    assert sorted(targets) == sorted([*drives, *data])
    assert [f.message.partition("the wire ")[2] for f in findings.warnings if "wire" in f.message] == lost


SEARCH = "the script iterates over {}, which is empty in an import: its work on the items is left out"
SET = "\na.get_attribute('inputs:x').set(len(found))"


@pytest.mark.parametrize(
    ("text", "warnings"),
    [
        ("for _ in 'ab': found = [prim for prim in stage.Traverse() if prim.IsActive()]" + SET, ["the stage"]),
        ("found = list(stage.GetPrimAtPath('/World/x').GetChildren())" + SET, ["UsdPrim.GetChildren"]),
        ("found, _ = stage.GetThings()\nfound = []" + SET, []),
        ("found = []" + SET + "\nfor prim in stage.Traverse(): print(prim)", []),
    ],
)
def test_a_script_that_looks_through_the_stage_before_it_builds_is_warned(
    text: str, warnings: list[str], tmp_path: Path
) -> None:
    _, told = built(tmp_path, "import omni.usd\nstage = omni.usd.get_context().get_stage()\n" + text)
    assert told == [SEARCH.format(what) for what in warnings]


@pytest.mark.parametrize(
    "number", ["float(size)", "int(size) + 1", "[0.5, -float(size[0]) / 2]", "round(float(size), 2)"]
)
def test_an_unknown_number_is_left_out_alone(number: str, tmp_path: Path) -> None:
    text = f"import omni.client\nsize = omni.client.stat('a').size\na.get_attribute('inputs:x').set({number})"
    graph, (warning,) = built(tmp_path, f"{text}\na.get_attribute('inputs:y').set(float('0.5'))")
    assert warning.startswith("the value of a.inputs:x is left out: it comes from omni.client.stat().size")
    assert {name: value.data for name, value in graph.nodes["a"].values.items()} == {"inputs:y": 0.5}
