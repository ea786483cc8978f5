"""Scripts in the styles that users of Isaac Sim write: what they build, and what is told of the rest."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.compiler.graph import Graph
from graphengine.format.diagnostics import Findings
from graphengine.isaac.script.script_source import Script
from graphengine.isaac.script.static_evaluation import evaluate
from tests.isaac.harness import ROOT, SCRIPTS, imported, meaning, recorded, resolved, texts

TUTORIAL = ("clock", "cmd_vel", "joint_states", "scan")
BUILDS: dict[str, dict[str, tuple[int, int]]] = {
    "absolute_paths": {"/World/Robots/absolute": (2, 1)},
    "async_evaluate": {"/World/async": (2, 1)},
    "camera_helpers": {"/World/robot/camera_graph": (7, 10)},
    "change_of_mind": {"/World/changed": (2, 1)},
    "class_builder": {"/World/leatherback/graphs/joints": (2, 1), "/World/leatherback/graphs/drive": (2, 1)},
    "compound": {"/World/compound": (4, 4)},
    "config_driven": {"/World/config": (4, 3)},
    "controller_instance": {"/World/states": (2, 1)},
    "enabling_extensions": {"/World/tf": (2, 1)},
    "endless_loop": {"/World/loop": (1, 0)},
    "extension_started": {"/World/from_extension": (3, 2)},
    "fleet_factory": {"/World/Graphs/jetbot": (6, 8), "/World/Graphs/carter": (6, 8)},
    "fstring_paths": {"/World/nova/odometry": (3, 4)},
    "grippers_and_conveyors": {"/World/ConveyorBeltGraph": (9, 9)},
    "guarded": {"/World/husky/joints": (2, 1)},
    "isaac_namespace": {"/World/dingo/base_link/cmd-vel.graph": (2, 1)},
    "look_around": {"/World/look": (4, 3)},
    "main_loop": {"/World/drive": (4, 2), "/World/states": (2, 1)},
    "module_beside": {"/World/jetbot/drive": (3, 3)},
    "nested_compound": {"/World/nested": (5, 5)},
    "numpy_values": {"/World/holonomic": (2, 1)},
    "old_names": {"/ActionGraph": (5, 5)},
    "old_slashes": {"/ActionGraph": (2, 1)},
    "physics_step": {"/World/fast": (2, 1)},
    "piece_by_piece": {"/World/pieces": (3, 3)},
    "push_graph": {"/World/PushGraph": (3, 2)},
    "robot_package/build": {"/World/relative": (3, 2)},
    "run_coroutine": {"/World/awaited": (2, 1), "/World/awaited_too": (2, 1)},
    "script_node": {"/World/script": (3, 3)},
    "script_ports": {"/World/ports": (3, 4)},
    "set_afterwards": {"/ActionGraph": (2, 1)},
    "several_edits": {"/World/graph": (3, 5)},
    "shared_inputs": {"/World/shared": (3, 4)},
    "single_items": {"/World/single": (2, 2)},
    "standalone_app": {"/ActionGraph": (5, 8)},
    "string_keys": {"/World/keys": (2, 1)},
    "try_except": {"/World/good": (1, 0)},
    "two_robots": {"/World/alpha_00/tf": (3, 6), "/World/beta_01/tf": (3, 6)},
    "type_probe": {"/World/probe": (3, 2)},
    "typed_values": {"/World/typed": (5, 4)},
    "types_in_parts": {"/World/types": (2, 1)},
    "usd_prims": {"/World/raw": (2, 1)},
    "usd_relationship": {"/World/relationships": (4, 3)},
    "variables": {"/World/variables": (3, 2)},
    "wheel_loop": {"/World/wheels": (7, 6)},
}
"""Nodes and wires of the graphs that a script builds, of which a check finds nothing wrong."""
LACKS: dict[str, str] = {
    "change_stage": "warning W302: /World/asked: not converted: the evaluation on demand by a script",
    "extension": "",
    "from_an_asset": "W302: no graph contains the node '/World/Carter/front_camera/render_product'",
    "mixed_bag": "the value of Counter.inputs:logicalLoad is left out: it comes from omni.isaac.core.World().get_physics_dt",
    "rtx_lidar": "the value of Lidar.inputs:renderProductPath is left out: it comes from omni.replicator.core.create.render",
    "unknown_places": "W302: the prim path <unknown: isaacsim.core.api.robots.Robot().prim_path>/joints of a graph is unknown",
    "unknown_types": "warning W301: Mine: the node type 'my_company.nodes.Blinker' is not available",
    "with_arguments": "error G401: the script ended with exit(2)",
}
"""What is told of scripts that cannot be carried over whole."""


def one(name: str, folder: Path, *arguments: str) -> tuple[Graph, Findings]:
    """The one graph that a script gives, and what is told of the import."""
    (path,), findings = imported(SCRIPTS / f"{name}.py", folder, *arguments)
    return resolved(path)[0], findings


@pytest.mark.parametrize("name", TUTORIAL)
def test_a_script_of_the_tutorial_gives_the_graph_that_ships(name: str, tmp_path: Path) -> None:
    (path,), findings = imported(SCRIPTS / "tutorial" / f"{name}.py", tmp_path)
    assert findings.items == []
    graph, told = resolved(path)
    assert told.items == []
    shipped, shipped_as = meaning(resolved(ROOT / "graphs" / "tutorial" / f"{name}.yaml")[0]), meaning(graph)
    for one in (shipped, shipped_as):
        one["nodes"], one["settled"] = sorted(one["nodes"]), None  # the two are written in different order
    assert shipped_as == shipped


@pytest.mark.parametrize("name", BUILDS)
def test_a_script_gives_graphs_that_resolve(name: str, tmp_path: Path) -> None:
    paths, findings = imported(SCRIPTS / f"{name}.py", tmp_path)
    assert findings.errors == []
    graphs = [resolved(path) for path in paths]
    found = {graph.prim_path: (len(graph.instances), len(graph.data_wires + graph.exec_wires)) for graph, _ in graphs}
    assert [finding.render() for _, told in graphs for finding in told.items] == []
    assert found == BUILDS[name]


@pytest.mark.parametrize("name", LACKS)
def test_what_cannot_be_carried_over_is_told(name: str, tmp_path: Path) -> None:
    paths, findings = imported(SCRIPTS / f"{name}.py", tmp_path)
    assert LACKS[name] in "\n".join(texts(findings))
    assert bool(paths) == (name not in ("extension", "with_arguments"))


def test_every_script_is_expected_to_give_something() -> None:
    known = {*BUILDS, *LACKS, "helper_function", "robot_facts"} - {"robot_package/build"}
    assert known == {path.stem for path in SCRIPTS.glob("*.py")}
    assert len(known) > 30


def test_a_type_that_is_not_here_is_told_at_its_place_and_kept(tmp_path: Path) -> None:
    (path,), findings = imported(SCRIPTS / "helper_function.py", tmp_path)
    (finding,) = findings.items
    assert (finding.code, str(finding.span)) == ("W301", f"{SCRIPTS / 'helper_function.py'}:14:18")
    assert [f.code for f in resolved(path)[1].errors] == ["G201"]


def test_values_have_the_types_of_their_ports(tmp_path: Path) -> None:
    product = one("camera_helpers", tmp_path)[0].by_id("Product")
    assert (product.value("width"), product.value("height")) == (640, 480)
    drive = one("numpy_values", tmp_path)[0].by_id("drive")
    assert drive.value("wheel_positions").tolist()[3] == [-0.2, -0.1, 0.0]
    assert drive.value("wheel_orientations").tolist()[0] == [1.0, 0.0, 0.0, 0.0]


def test_typed_values_settle_ports_of_several_types(tmp_path: Path) -> None:
    graph, _ = one("typed_values", tmp_path)
    assert str(graph.by_id("Add").settled["sum"]) == "double[3]"
    assert graph.by_id("Add").value("a") == (2.0, 4.0, 6.0)


def test_values_that_are_set_in_any_way_arrive(tmp_path: Path) -> None:
    twist = one("set_afterwards", tmp_path)[0].by_id("SubscribeTwist").entry.spec.inputs
    assert twist == {"topicName": "robot/cmd_vel", "queueSize": 1, "nodeNamespace": "fleet", "qosProfile": ""}
    graph, _ = one("usd_relationship", tmp_path)
    assert graph.by_id("Odom").entry.spec.inputs == {"chassisPrim": ["/World/robot/base"]}
    joints = {"targetPrim": ["/World/robot"], "topicName": "robot/joint_states"}
    assert graph.by_id("Joints").entry.spec.inputs == joints
    assert graph.flat.spec.layout == {"Joints": (420.0, -35.5)}


def test_variables_keep_types_and_defaults(tmp_path: Path) -> None:
    graph, _ = one("variables", tmp_path)
    assert graph.variables == {"speed": 1.5, "names": ("left", "right"), "home": (0.0, 1.0, 2.0)}


def test_types_may_be_put_together_of_their_parts(tmp_path: Path) -> None:
    graph, _ = one("types_in_parts", tmp_path)
    types = {"gain": "double", "names": "token[]", "goal": "pointd[3]", "late": "colorf[3]"}
    assert {name: str(kind) for name, kind in graph.variable_types.items()} == types
    assert graph.variables == {"gain": 0.25, "names": ("left", "right"), "goal": (0.0,) * 3, "late": (0.5, 1.0, 0.0)}
    declared = graph.by_id("script").entry.spec.inputs["attributes"]
    assert declared == ["inputs:velocity double[3]", "outputs:ok bool", "outputs:wheels double[]"]
    assert (
        "      script: |\n        def compute(db):\n            db.outputs.ok = True\n"
        in graph.flat.loaded.document.path.read_text("utf-8")
    )


def test_graphs_that_come_with_an_asset_are_told_and_the_others_are_kept(tmp_path: Path) -> None:
    (path,), findings = imported(SCRIPTS / "from_an_asset.py", tmp_path)
    assert path.name == "clock.yaml"
    assert [str(finding.span).rpartition(".py:")[2] for finding in findings.warnings] == ["8:19", "9:1", "17:60"]
    advice = "a USD file that the script opens may contain it; import that file too"
    assert {finding.help for finding in findings.warnings} == {(advice,)}


def test_a_graph_whose_place_cannot_be_told_is_found_again(tmp_path: Path) -> None:
    graph, findings = one("unknown_places", tmp_path)
    assert (graph.prim_path, graph.by_id("states").entry.spec.inputs) == ("/World/joints", {"topicName": "states"})
    assert "comes from the default of /World/joints/states.inputs:queueSize" in texts(findings)[-1]


def test_modules_above_a_script_are_told_by_their_own_names(tmp_path: Path) -> None:
    _, findings = imported(SCRIPTS / "robot_package" / "build.py", tmp_path)
    assert [finding.message for finding in findings.items] == [
        "module 'common' is not imported",
        "common.logs.info() does not belong to a graph and is left out",
    ]


def test_an_on_demand_graph_of_physics_steps_runs_at_every_physics_step(tmp_path: Path) -> None:
    assert one("physics_step", tmp_path)[0].runs == "physics_step"
    late, asked = imported(SCRIPTS / "change_stage.py", tmp_path)[0]
    assert (resolved(late)[0].runs, resolved(asked)[0].runs) == ("physics_step", "tick")


def test_a_graph_without_an_evaluator_is_a_push_graph(tmp_path: Path) -> None:
    graph, findings = one("push_graph", tmp_path)
    assert graph.flat.spec.evaluator == "push"
    assert "/World/PushGraph is a push graph" in texts(findings)[0]


def test_a_compound_is_taken_apart(tmp_path: Path) -> None:
    assert [str(wire) for wire in one("compound", tmp_path)[0].data_wires] == [
        "Doubled_Two.value -> Doubled_Multiply.b",
        "Tick.deltaSeconds -> Doubled_Multiply.a",
        "Doubled_Multiply.product -> Diff.dt",
    ]


def test_an_input_that_a_compound_shares_goes_to_all_its_nodes(tmp_path: Path) -> None:
    graph, _ = one("shared_inputs", tmp_path)
    assert [node.literals for node in graph.instances[1:]] == [{"topic_name": "time"}] * 2


def test_a_single_pair_may_begin_with_an_attribute_and_its_node(tmp_path: Path) -> None:
    assert one("single_items", tmp_path)[0].by_id("Clock").literals == {"topic_name": "time"}


def test_names_that_a_file_cannot_hold_are_changed_and_told(tmp_path: Path) -> None:
    graph, findings = one("isaac_namespace", tmp_path)
    assert [instance.id for instance in graph.instances] == ["On_Tick", "_1st"]
    assert graph.by_id("_1st").value("topic_name") == "$(cmd)/vel"
    assert graph.flat.loaded.document.path.name == "cmd_vel_graph.yaml"
    told = "\n".join(texts(findings))
    assert "node 'On Tick' is named 'On_Tick' in the file" in told


def test_old_names_of_types_are_told_and_old_ports_are_left_out(tmp_path: Path) -> None:
    graph, findings = one("old_names", tmp_path)
    assert [f.code for f in findings.sorted()] == ["N101"] * 4 + ["W302"] * 2
    assert graph.by_id("PublishTF").cls.type_name == "isaacsim.ros2.bridge.ROS2PublishTransformTree"
    assert graph.by_id("Articulation").entry.spec.inputs == {"targetPrim": ["/World/robot"]}


def test_arguments_reach_the_script(tmp_path: Path) -> None:
    graph, findings = one("with_arguments", tmp_path, "--rate", "3", "--robot", "/World/r2")
    assert findings.errors == []
    assert (graph.prim_path, graph.by_id("Gate").entry.spec.inputs) == ("/World/r2/gate", {"step": 3})


def test_a_script_of_literals_is_evaluated_without_being_run_and_gives_the_same() -> None:
    path = SCRIPTS / "tutorial" / "joint_states.py"
    plain = evaluate(Script(str(path), path.read_text(encoding="utf-8")))
    assert plain is not None
    assert recorded(path, "--an-argument-makes-it-run") == (list(plain.graphs.values()), [])


@pytest.mark.parametrize(
    "name", ["two_robots", "numpy_values", "async_evaluate", "class_builder", "guarded", "with_arguments"]
)
def test_a_script_that_does_more_has_to_be_run(name: str) -> None:
    path = SCRIPTS / f"{name}.py"
    assert evaluate(Script(str(path), path.read_text(encoding="utf-8"))) is None


def test_a_script_that_doubles_a_text_without_end_is_not_evaluated() -> None:
    text = "import omni.graph.core as og\na = 'a'\n" + "a = a + a\n" * 60 + "og.Controller.edit('/World/graph', {})\n"
    assert evaluate(Script("doubling.py", text)) is None
    assert evaluate(Script("once.py", text.replace("a = a + a\n", ""))) is not None


def test_a_value_that_only_omniverse_knows_is_told_at_its_place(tmp_path: Path) -> None:
    _, findings = imported(SCRIPTS / "rtx_lidar.py", tmp_path)
    (warning,) = findings.warnings
    assert str(warning.span) == f"{SCRIPTS / 'rtx_lidar.py'}:25:14"
    assert warning.help == ("set it in the file",)
