from pathlib import Path

import pytest

pytest.importorskip("pxr")

from tests.isaac.harness import composed
from tests.isaac.stage.harness import node, read, read_graph

FIRED = "custom uint outputs:tick (customData = { bool isExecution = 1 })"
TICK = node("Tick", "omni.graph.action.OnPlaybackTick", FIRED)
ADD = "omni.graph.nodes.Add"
META = "(customData = { dictionary omni = { dictionary graph = {\n%s\n} } })"


def extended(line: str) -> str:
    return f"custom token inputs:a {META % line}"


def test_connections_may_be_absolute_relative_and_to_the_input_of_a_constant(tmp_path: Path) -> None:
    counter = node("Count", "omni.graph.action.Counter", "prepend uint inputs:execIn.connect = <../Tick.outputs:tick>")
    ends = "token inputs:a.connect = </G/C.inputs:value>", "token inputs:b.connect = </G/Count.outputs:count>"
    add = node("Add", ADD, *ends)
    stage = read_graph(tmp_path, TICK, counter, node("C"), add)
    assert stage.wires == [
        "Tick.outputs:tick -> Count.inputs:execIn",
        "C.inputs:value -> Add.inputs:a",
        "Count.outputs:count -> Add.inputs:b",
    ]
    assert not stage.findings.items


def test_an_execution_input_takes_several_wires_and_has_no_value(tmp_path: Path) -> None:
    pin = "custom uint inputs:execIn = 1 (customData = { bool isExecution = 1 })"
    wires = "uint inputs:execIn.connect = [</G/A.outputs:tick>, </G/B.outputs:tick>]"
    tick = "omni.graph.action.OnPlaybackTick"
    count = node("Count", "omni.graph.action.Counter", pin, wires)
    stage = read_graph(tmp_path, node("A", tick), node("B", tick), count)
    assert stage.wires == ["A.outputs:tick -> Count.inputs:execIn", "B.outputs:tick -> Count.inputs:execIn"]
    assert not stage.graph.nodes["Count"].values


def test_a_wire_from_a_prim_that_is_no_node_becomes_its_value_and_is_told(tmp_path: Path) -> None:
    constant = node("C", ADD, "custom double inputs:a = 1", "double inputs:a.connect = </Cube.size>")
    stage = read_graph(tmp_path, constant, after='def Cube "Cube" { double size = 2.5 }')
    assert stage.value("C", "a") == 2.5
    assert not stage.wires
    assert "N301: /G/C.inputs:a keeps the value of /Cube.size" in stage.told


def test_a_wire_from_another_graph_is_left_out_and_told_at_its_node(tmp_path: Path) -> None:
    other = f'def OmniGraph "H" {{ {node("D")} }}'
    stage = read_graph(tmp_path, node("C", ADD, "double inputs:a.connect = </H/D.outputs:value>"), after=other)
    assert "stage.usda:5:20: warning W302: the wire /H/D.outputs:value -> /G/C.inputs:a" in stage.told


def test_targets_are_prims_or_wires_where_they_end_in_a_property(tmp_path: Path) -> None:
    prims = node("Two", "isaacsim.core.nodes.IsaacComputeTransformTree", "rel inputs:targetPrims = [</A>, <..>]")
    wired = node("One", "omni.graph.nodes.GetPrimPath", "rel inputs:prim = </G/Prim.outputs:prim>")
    stage = read_graph(tmp_path, node("Prim", "omni.graph.nodes.GetGraphTargetPrim"), prims, wired, after='def "A" {}')
    assert stage.value("Two", "targetPrims") == ["/A", "/G"]
    assert stage.wires == ["Prim.outputs:prim -> One.inputs:prim"]


def test_a_target_may_be_a_node_of_the_graph_itself(tmp_path: Path) -> None:
    stage = read_graph(tmp_path, TICK, node("Path", "omni.graph.nodes.GetPrimPath", "rel inputs:prim = </G/Tick>"))
    assert stage.value("Path", "prim") == ["/G/Tick"]
    assert not stage.wires


def test_a_bundle_is_wired_from_the_prim_of_an_output(tmp_path: Path) -> None:
    reader = node("C", ADD, "rel inputs:a = </G/B/outputs_bundle>")
    stage = read_graph(tmp_path, node("B", below='def "outputs_bundle" {}'), reader)
    assert stage.wires == ["B.outputs:bundle -> C.inputs:a"]


@pytest.mark.parametrize(
    ("line", "type", "value"),
    [
        ('double attrValue = 0.5\nstring resolvedType = "double"', "double", 0.5),
        ('string attrType = "Any"\ntoken attrValue = "x"\nstring resolvedType = "token"', "token", "x"),
        ('double[] attrValue = [1, 2]\nstring resolvedType = "double[]"', "double[]", [1.0, 2.0]),
        ('quatd attrValue = (1, 2, 3, 4)\nstring resolvedType = "quatd[4]"', "quatd[4]", [2.0, 3.0, 4.0, 1.0]),
    ],
)
def test_the_value_of_a_port_of_several_types_stands_in_its_metadata(
    tmp_path: Path, line: str, type: str, value: object
) -> None:
    found = read_graph(tmp_path, node("A", ADD, extended(line))).graph.nodes["A"].values["inputs:a"]
    assert (found.type, found.data) == (type, value)


def test_a_port_of_several_types_that_is_not_resolved_has_no_value(tmp_path: Path) -> None:
    stage = read_graph(tmp_path, node("A", ADD, extended('string attrType = "Union-->double,float"')))
    assert not stage.graph.nodes["A"].values


@pytest.mark.parametrize(
    ("usd", "text", "type", "value"),
    [
        ("bool", "1", "bool", True),
        ("uchar", "7", "uchar", 7),
        ("uint64", "18446744073709551615", "uint64", 2**64 - 1),
        ("float", "0.1", "float", 0.1),
        ("half", "0.1", "half", 0.1),
        ("double", "1e-300", "double", 1e-300),
        ("timecode", "3", "timecode", 3.0),
        ("token", '"cmd_vel"', "token", "cmd_vel"),
        ("string", '"räder"', "string", "räder"),
        ("asset", "@../script.py@", "token", "../script.py"),
        ("int2", "(1, 2)", "int[2]", [1, 2]),
        ("float3", "(0.1, 2, 3)", "float[3]", [0.1, 2.0, 3.0]),
        ("vector3d", "(1, 2, 3)", "vectord[3]", [1.0, 2.0, 3.0]),
        ("color4f", "(0.1, 0.2, 0.3, 1)", "colorf[4]", [0.1, 0.2, 0.3, 1.0]),
        ("texCoord2h", "(0.5, 1)", "texcoordh[2]", [0.5, 1.0]),
        ("quatd", "(1, 2, 3, 4)", "quatd[4]", [2.0, 3.0, 4.0, 1.0]),
        ("quatf[]", "[(1, 0, 0, 0), (0, 1, 0, 0)]", "quatf[4][]", [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0]]),
        ("matrix2d", "((1, 2), (3, 4))", "matrixd[2]", [[1.0, 2.0], [3.0, 4.0]]),
        ("double[]", "[]", "double[]", []),
        ("token[]", '["left", "right"]', "token[]", ["left", "right"]),
        ("int[]", "[-1, 2]", "int[]", [-1, 2]),
        ("bool[]", "[1, 0]", "bool[]", [True, False]),
        ("point3f[]", "[(1, 2, 3)]", "pointf[3][]", [[1.0, 2.0, 3.0]]),
    ],
)
def test_values_have_our_types_and_order(tmp_path: Path, usd: str, text: str, type: str, value: object) -> None:
    stage = read_graph(tmp_path, node("N", "example.Node", f"custom {usd} inputs:x = {text}"))
    found = stage.graph.nodes["N"].values["inputs:x"]
    assert (found.type, found.data) == (type, value)


def test_a_value_that_no_port_holds_or_that_changes_with_time_is_told(tmp_path: Path) -> None:
    huge = f"custom int[] inputs:many = [{', '.join(['1'] * 100_001)}]"
    stage = read_graph(tmp_path, node("N", ADD, "custom double inputs:a.timeSamples = { 0: 1, 1: 2 }", huge))
    assert stage.contents.left_out == [
        ("/G/N.inputs:a", "its value changes with time"),
        ("/G/N.inputs:many", "it has more than 100000 items"),
    ]


def test_a_wired_input_keeps_no_value_of_its_own(tmp_path: Path) -> None:
    add = node("A", ADD, "custom double inputs:a = 4", "double inputs:a.connect = </G/C.inputs:value>")
    assert not read_graph(tmp_path, node("C"), add).graph.nodes["A"].values


def test_variables_settings_and_positions_are_read(tmp_path: Path) -> None:
    text = """#usda 1.0
def OmniGraph "G" {
    token evaluator:type = "dirty_push"
    token pipelineStage = "pipelineStageOnDemand"
    custom double graph:variable:speed = 1.5
    custom token[] graph:variable:names
    def OmniGraphNode "N" (prepend apiSchemas = ["NodeGraphNodeAPI"]) {
        token node:type = "omni.graph.nodes.ConstantDouble"
        uniform float2 ui:nodegraph:node:pos = (-12.3, 40)
    }
}
"""
    graph = read(tmp_path, text).graph
    assert (graph.path, graph.evaluator, graph.pipeline_stage) == ("/G", "dirty_push", "on_demand")
    assert graph.nodes["N"].position == (-12.3, 40.0)
    assert {name: (value.type, value.data) for name, value in graph.variables.items()} == {
        "names": ("token[]", None),
        "speed": ("double", 1.5),
    }


def test_a_graph_that_names_no_evaluator_is_a_push_graph_and_an_unknown_one_is_told(tmp_path: Path) -> None:
    stage = read(tmp_path, '#usda 1.0\ndef OmniGraph "A" {}\ndef OmniGraph "B" { token evaluator:type = "magic" }')
    assert [graph.evaluator for graph in stage.graphs] == ["push", "push"]
    assert "'magic'" in stage.told


def test_inactive_prims_and_graphs_of_replicator_are_no_graphs(tmp_path: Path) -> None:
    text = f"""#usda 1.0
def Scope "Off" (active = false) {{ def OmniGraph "G" {{}} }}
def Scope "Render" {{ def Scope "PostProcess" {{ def OmniGraph "SDGPipeline" {{}} }} }}
def OmniGraph "On" {{ def OmniGraphNode "Off" (active = false) {{}}
{node("C")} }}
"""
    stage = read(tmp_path, text)
    assert [graph.path for graph in stage.graphs] == ["/On"]
    assert list(stage.graph.nodes) == ["C"]
    assert "N302: the graph /Render/PostProcess/SDGPipeline" in stage.told


def test_references_variants_and_overs_are_composed(tmp_path: Path) -> None:
    asset = f"""#usda 1.0
def Xform "Robot" (
    variants = {{ string ROS = "on" }}
    prepend variantSets = "ROS"
) {{
    variantSet "ROS" = {{
        "on" {{ def OmniGraph "G" {{ {node("C", "omni.graph.nodes.ConstantDouble", "custom double inputs:value = 1")}
            {node("Path", "omni.graph.nodes.GetPrimPath", "rel inputs:prim = </Robot>")} }}
        }}
        "off" {{
        }}
    }}
}}
"""
    text = """#usda 1.0
def "World" {
    def "a" (prepend references = @robot.usda@</Robot>) { over "G" { over "C" { double inputs:value = 2 } } }
    def "b" (
        prepend payload = @./robot.usda@</Robot>
        variants = { string ROS = "off" }
    ) {}
    def "c" (
        instanceable = true
        prepend references = @robot.usda@</Robot>
    ) {}
}
"""
    stage = read(tmp_path, text, robot=asset)
    assert [graph.path for graph in stage.graphs] == ["/World/a/G", "/World/c/G"]
    assert [graph.nodes["C"].values["inputs:value"].data for graph in stage.graphs] == [2.0, 1.0]
    assert [graph.nodes["Path"].values["inputs:prim"].data for graph in stage.graphs] == [["/World/a"], ["/World/c"]]


def test_a_graph_below_a_prim_of_an_asset_that_is_not_there_is_read(tmp_path: Path) -> None:
    text = f"""#usda 1.0
def Xform "dd100" (prepend references = @https://example.org/dd100.usd@) {{
    over "base_link" {{
        custom string isaac:namespace = "dd100_0000"
        def OmniGraph "cmd_vel" {{ {node("C")} }}
    }}
}}
"""
    stage = read(tmp_path, text)
    assert stage.graph.path == "/dd100/base_link/cmd_vel"
    assert stage.contents.prims["/dd100/base_link"].text("isaac:namespace") == "dd100_0000"
    assert stage.contents.left_out == [
        ("https://example.org/dd100.usd", "it is on a server, which is never asked; needed by /dd100")
    ]


COMPOUND = 'omni.graph.nodes.CompoundSubgraph"\nrel omni:graph:compoundGraph = <{}>\ntoken made = "'


def compound(name: str, inner: str, *lines: str) -> str:
    """The text of a compound node; `inner` are the nodes in it."""
    return node(name, COMPOUND.format("Graph"), *lines, below=f'def OmniGraph "Graph" {{ {inner} }}')


def add(name: str, source: str) -> str:
    return node(name, ADD, f"double inputs:a.connect = <{source}>")


def test_compounds_become_flat_and_pass_wires_and_values_through(tmp_path: Path) -> None:
    ends = "double inputs:a.connect = </G/C.inputs:left>", "double inputs:b.connect = </G/C.inputs:right>"
    inner = node("Sum", ADD, *ends)
    lines = "double inputs:left.connect = </G/Left.inputs:value>", "double inputs:right = 3"
    outer = compound("C", inner, *lines, "double outputs:sum.connect = </G/C/Graph/Sum.outputs:sum>")
    reader = node("Out", "omni.graph.nodes.ToString", "double inputs:value.connect = </G/C.outputs:sum>")
    stage = read_graph(tmp_path, node("Left"), outer, reader)
    assert list(stage.graph.nodes) == ["Left", "C/Sum", "Out"]
    assert stage.wires == ["Left.inputs:value -> C/Sum.inputs:a", "C/Sum.outputs:sum -> Out.inputs:value"]
    assert stage.value("C/Sum", "b") == 3.0


def test_prims_and_wires_of_prims_pass_through_compounds(tmp_path: Path) -> None:
    inner = node("Path", "omni.graph.nodes.GetPrimPath", "rel inputs:prim = </G/C.inputs:prim>")
    empty = node("Empty", "omni.graph.nodes.GetPrimPath", "rel inputs:prim = </G/C.inputs:nothing>")
    lines = "rel inputs:prim = [</A>, </G/Own.outputs:prim>]", "rel inputs:nothing"
    outer = compound("C", f"{inner}\n{empty}", *lines)
    stage = read_graph(tmp_path, node("Own", "omni.graph.nodes.GetGraphTargetPrim"), outer)
    assert stage.value("C/Path", "prim") == ["/A"]
    assert stage.wires == ["Own.outputs:prim -> C/Path.inputs:prim"]
    assert not stage.graph.nodes["C/Empty"].values


def test_compounds_in_compounds_become_flat_too(tmp_path: Path) -> None:
    inner = compound("D", add("N", "/G/C/Graph/D.inputs:x"), "double inputs:x.connect = </G/C.inputs:x>")
    outer = compound("C", inner, "double inputs:x.connect = </G/K.inputs:value>")
    assert read_graph(tmp_path, node("K"), outer).wires == ["K.inputs:value -> C/D/N.inputs:a"]


def test_a_compound_that_is_wired_to_itself_or_holds_its_own_graph_comes_to_an_end(tmp_path: Path) -> None:
    circular = compound("C", add("N", "/G/C.inputs:x"), "double inputs:x.connect = </G/C.inputs:x>")
    assert not read_graph(tmp_path, circular).wires
    stage = read_graph(tmp_path, node("C", COMPOUND.format("/G")))
    assert not stage.graph.nodes
    assert "W302: the compound /G/C is left out: it contains no graph" in stage.told


def test_very_many_compounds_in_a_row_or_in_each_other_come_to_an_end(tmp_path: Path) -> None:
    kind = COMPOUND.format("Graph")
    row = [node(f"C{n}", kind, f"double outputs:x.connect = </G/C{n + 1}.outputs:x>") for n in range(2000)]
    assert not read_graph(tmp_path, *row, add("R", "/G/C0.outputs:x")).wires
    deep = node("N")
    for _ in range(60):
        deep = compound("C", deep)
    stage = read_graph(tmp_path, deep)
    assert not stage.graph.nodes
    assert "is left out: it is over 50 levels deep" in stage.told


def test_each_prim_that_refers_to_a_graph_gets_one_of_its_own(tmp_path: Path) -> None:
    path = node("Path", "omni.graph.nodes.GetPrimPath", 'custom token inputs:prim = "_OMNI_GRAPH_TARGET"')
    graph = f'def OmniGraph "G" {{ custom double graph:variable:speed = 1\n{path} }}'
    users = 'def "a" { rel omniGraphs = </G> }\n'
    users += 'def "b" { rel omniGraphs = </G>\ncustom double graph:variable:speed = 2 }'
    stage = read(tmp_path, f"#usda 1.0\n{graph}\n{users}")
    assert [graph.path for graph in stage.graphs] == ["/a/G", "/b/G"]
    assert [graph.variables["speed"].data for graph in stage.graphs] == [1.0, 2.0]
    assert [graph.nodes["Path"].values["inputs:prim"].data for graph in stage.graphs] == ["/a", "/b"]
    assert "N301: /G becomes one graph below each prim that refers to it: /a, /b" in stage.told


def test_a_standalone_graph_has_no_instances_and_an_instanced_one_without_any_is_told(tmp_path: Path) -> None:
    alone = 'def OmniGraph "A" { token evaluationMode = "Standalone" }\ndef "u" { rel omniGraphs = [</A>, </Gone>] }'
    stage = read(tmp_path, f'#usda 1.0\n{alone}\ndef OmniGraph "B" {{ token evaluationMode = "Instanced" }}')
    assert [graph.path for graph in stage.graphs] == ["/A"]
    assert "W302: /B is left out: it is evaluated only for prims that refer to it, and no prim does" in stage.told
    assert "W302: /u refers to a graph at /Gone, but there is no graph" in stage.told


def test_nodes_of_an_old_version_are_told_and_an_old_context_keeps_its_meaning(tmp_path: Path) -> None:
    context = node("Context", "omni.isaac.ros2_bridge.ROS2Context", "int node:typeVersion = 1")
    helper = node("Lidar", "isaacsim.ros2.bridge.ROS2RtxLidarHelper", "int node:typeVersion = 2")
    current = node("Tick", "omni.graph.action.OnPlaybackTick", "int node:typeVersion = 2")
    stage = read_graph(tmp_path, context, helper, current)
    assert stage.value("Context", "useDomainIDEnvVar") is False
    helper = "isaacsim.ros2.bridge.ROS2RtxLidarHelper"
    assert f"/G/Lidar was saved as version 2 of {helper}, whose current version is 3" in stage.told
    assert len(stage.findings.items) == 2


def test_a_script_node_declares_the_ports_that_were_added_to_it(tmp_path: Path) -> None:
    lines = (
        'custom string inputs:script = """def compute(db):\n    return {1: "}"}\n"""',
        "custom double inputs:speed = 1",
        "custom uint outputs:done (customData = { bool isExecution = 1 })",
        "custom double[] outputs:command",
    )
    found = read_graph(tmp_path, node("S", "omni.graph.scriptnode.ScriptNode", *lines), node("After")).graph.nodes
    ports = {"inputs:speed": "double", "outputs:command": "double[]", "outputs:done": "execution"}
    assert found["S"].attributes == ports
    assert found["After"].span is not None
    assert found["After"].span.line > 5


def test_prims_may_have_names_in_any_alphabet(tmp_path: Path) -> None:
    assert list(read_graph(tmp_path, node("Räder")).graph.nodes) == ["Räder"]


@pytest.mark.parametrize(
    "line",
    [
        'custom double inputs:a = 1 (customData = { string omni = "x" })',
        'custom double inputs:a = 1 (customData = { dictionary omni = { string graph = "x" } })',
        "custom double inputs:a = 1 (customData = { dictionary omni = { dictionary graph = { int attrType = 3 } } })",
    ],
)
def test_odd_metadata_is_passed_over(tmp_path: Path, line: str) -> None:
    assert read_graph(tmp_path, node("A", ADD, line)).value("A", "a") == 1.0


def test_properties_of_an_odd_kind_are_passed_over(tmp_path: Path) -> None:
    lines = (
        "int node:type = 3",
        'string node:typeVersion = "new"',
        "custom double[] ui:nodegraph:node:pos = [1]",
        "custom double omni:graph:compoundGraph = 1",
    )
    odd = 'def OmniGraphNode "N" {\n' + "\n".join(lines) + "\n}\n"
    found = read_graph(tmp_path, odd).graph.nodes["N"]
    assert (found.type, found.position, found.values) == ("", None, {})


def test_a_stage_without_graphs_has_none(tmp_path: Path) -> None:
    assert not read(tmp_path, "#usda 1.0\n").graphs


def test_a_stage_sets_up_a_holonomic_base_from_the_prims_of_its_robot(tmp_path: Path) -> None:
    family = "isaacsim.robot.wheeled_robots"
    given = "custom rel inputs:robotPrim = </Bot>", "custom rel inputs:comPrim = </Bot/base_link>"
    setup = node("Setup", f"{family}.HolonomicRobotUsdSetup", *given, "custom bool inputs:usePath = 0")
    wires = [f"double[] inputs:{port}.connect = </G/Setup.outputs:{port}>" for port in ("wheelRadius", "mecanumAngles")]
    controller = node("Controller", f"{family}.HolonomicController", *wires)
    robot = 'def Xform "Bot" { def Xform "base_link" { } }'
    stage = read_graph(tmp_path, TICK, setup, controller, after=robot)
    assert stage.value("Setup", "robotPrim") == ["/Bot"]
    assert stage.value("Setup", "comPrim") == ["/Bot/base_link"]
    assert sorted(stage.wires, reverse=True) == [
        "Setup.outputs:wheelRadius -> Controller.inputs:wheelRadius",
        "Setup.outputs:mecanumAngles -> Controller.inputs:mecanumAngles",
    ]


@pytest.mark.parametrize(
    "name",
    [
        "isaacsim.core.experimental.actuators.ArticulationActuators",
        "isaacsim.core.nodes.IsaacConvertDepthToPointCloud",
        "isaacsim.core.nodes.IsaacConvertRGBAToRGB",
        "isaacsim.core.nodes.IsaacTestNode",
        "isaacsim.ros2.bridge.ROS2RtxRadarHelper",
        "isaacsim.sensors.rtx.IsaacCreateRTXLidarScanBuffer",
        "isaacsim.sensors.rtx.nodes.OgnIsaacExtractRTXSensorPointCloud",
    ],
)
def test_a_stage_with_a_node_for_sensors_or_actuators_is_carried_over_whole(tmp_path: Path, name: str) -> None:
    pin = "exec" if ".rtx." in name else "execIn"
    stage = read_graph(tmp_path, TICK, node("N", name, f"uint inputs:{pin}.connect = </G/Tick.outputs:tick>"))
    text, findings = composed(stage.graph)
    assert f"type: {name}" in text or f"N: {name}" in text
    assert f"Tick.tick -> N.{pin}" in text
    assert [finding.render() for finding in (*stage.findings.items, *findings.items)] == []


def test_the_graph_of_a_conveyor_and_a_gripper_is_read_and_composed(tmp_path: Path) -> None:
    """As Isaac Sim makes the first for a conveyor: its time is a double, which the conveyor takes as a float."""
    tick = node("OnTick", "omni.graph.action.OnPlaybackTick", FIRED, "custom double outputs:deltaSeconds")
    belt = node(
        "ConveyorNode",
        "isaacsim.asset.gen.conveyor.IsaacConveyor",
        "rel inputs:conveyorPrim = </belt>",
        "custom float inputs:velocity = 0.25",
        "custom float3 inputs:direction = (0, 1, 0)",
        "uint inputs:onStep.connect = </G/OnTick.outputs:tick>",
        "float inputs:delta.connect = </G/OnTick.outputs:deltaSeconds>",
    )
    cup = node(
        "Cup",
        "isaacsim.robot.surface_gripper.SurfaceGripper",
        "rel inputs:SurfaceGripper = </robot/cup>",
        "uint inputs:Close.connect = </G/OnTick.outputs:tick>",
    )
    stage = read_graph(tmp_path, tick, belt, cup, after='def "belt" {\n}\ndef "robot" {\ndef "cup" {\n}\n}\n')
    text, findings = composed(stage.graph)
    assert [finding.code for finding in findings.items] == ["N301"]
    for line in (
        "inputs: {direction: [0.0, 1.0, 0.0], velocity: 0.25, conveyorPrim: [/belt]}",
        "inputs: {SurfaceGripper: [/robot/cup]}",
        "- OnTick.tick -> ConveyorNode.onStep",
        "- OnTick_deltaSeconds_as_float.converted -> ConveyorNode.delta",
        "- OnTick.tick -> Cup.Close",
    ):
        assert line in text
