"""Exported scripts: import(export(graph)) is the graph, for those that ship and for random ones."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.compiler.graph import Graph
from graphengine.compiler.registry import default_registry
from graphengine.format.diagnostics import Findings
from graphengine.format.yaml_text import flow
from graphengine.isaac.export import write_script
from graphengine.isaac.graph_file import compose
from graphengine.isaac.script.script_source import Script
from graphengine.isaac.script.static_evaluation import evaluate
from graphengine.node import Node, PortType, UnionType
from graphengine.node.node_class import grown
from graphengine.node.port import Port
from graphengine.node.types import coerce
from tests.isaac.harness import ROOT, SCRIPTS, imported, meaning, resolved

SHIPPED = sorted((ROOT / "graphs").rglob("*.yaml"))
NO_TIMEOUT = "SubscribeTwist: isaacsim.ros2.bridge.ROS2SubscribeTwist has no inputs:timeout in Isaac Sim"
NO_SCALING = (
    "Controller: isaacsim.robot.wheeled_robots.DifferentialController has no inputs:scaleWheelSpeeds in Isaac Sim"
)
NO_ROLLING = "Controller: isaacsim.robot.wheeled_robots.HolonomicController has no inputs:rolling in Isaac Sim"


def _wheel_odometry(node: str, publisher: str) -> list[str]:
    publishes = f"{publisher}: isaacsim.ros2.bridge.ROS2PublishOdometry"
    return [
        f"{node}: Isaac Sim has no node type graphengine.wheeled_robots.ComputeWheelOdometry",
        f"{publishes} has no inputs:poseCovariance in Isaac Sim",
        f"{publishes} has no inputs:twistCovariance in Isaac Sim",
    ]


REFUSED = {
    "dd100/cmd_vel": [NO_TIMEOUT],
    "demo/round": [
        "Nearest: Isaac Sim has no node type graphengine.data.NearestRange",
        "Ahead: Isaac Sim has no node type graphengine.data.NearestRange",
        NO_TIMEOUT,
    ],
    "base/ackermann": [NO_TIMEOUT, *_wheel_odometry("State/Odometry", "State/PublishOdometry")],
    "base/differential": [NO_TIMEOUT, NO_SCALING, *_wheel_odometry("State/Odometry", "State/PublishOdometry")],
    "base/mecanum": [NO_TIMEOUT, NO_ROLLING, *_wheel_odometry("State/Odometry", "State/PublishOdometry")],
    "base/omni": [NO_TIMEOUT, NO_ROLLING],
    "arm/gripper": ["Gripper: Isaac Sim has no node type graphengine.ros2.ROS2GripperCommand"],
    "arm/trajectory": ["Trajectory: Isaac Sim has no node type graphengine.ros2.ROS2FollowJointTrajectory"],
    "base/state": _wheel_odometry("Odometry", "PublishOdometry"),
    "publishers/compressed_camera": [
        f"Colour: isaacsim.ros2.bridge.ROS2CameraHelper has no inputs:{port} in Isaac Sim"
        for port in ("compression", "jpegQuality")
    ],
    "publishers/depth_camera": ["Points: isaacsim.ros2.bridge.ROS2CameraHelper has no inputs:organized in Isaac Sim"],
    "publishers/rgbd_camera": [
        f"Points: isaacsim.ros2.bridge.ROS2CameraHelper has no inputs:{port} in Isaac Sim"
        for port in ("colored", "organized")
    ],
    "publishers/force_torque": ["PublishWrench: Isaac Sim has no node type graphengine.ros2.ForceTorquePublisher"],
    "publishers/navsat": ["PublishFix: Isaac Sim has no node type graphengine.ros2.NavSatPublisher"],
    "publishers/range": ["PublishRange: Isaac Sim has no node type graphengine.ros2.RangePublisher"],
    "wheel_odometry": _wheel_odometry("WheelOdometry", "PublishOdom"),
    "localization": ["PublishGroundTruth: Isaac Sim has no node type graphengine.ros2.ROS2PublishGroundTruthTransform"],
    "robot_state": ["RobotState: Isaac Sim has no node type graphengine.ros2.RobotStatePublisher"],
}


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT / "graphs").with_suffix(""))


def again(graph: Graph, folder: Path, *, whole: bool = True) -> tuple[Graph, str]:
    """A graph exported and imported, and the script; `whole` if nothing of the graph is left out."""
    findings = Findings()
    text = write_script(graph, findings)
    assert bool(findings.items) != whole
    findings = Findings()
    recorder = evaluate(Script("exported.py", text))
    assert recorder is not None, text
    (recorded,) = recorder.graphs.values()
    path = folder / "again.yaml"
    made = compose(recorded, graph.flat.spec.graph, default_registry(), findings, "a script")
    path.write_text(made, encoding="utf-8")
    return resolved(path)[0], text


def there_and_back(text: str, folder: Path) -> str:
    """The script of a graph file that comes back as it was."""
    path = folder / "graph.yaml"
    path.write_text(text, encoding="utf-8")
    graph, _ = resolved(path)
    back, script = again(graph, folder)
    assert meaning(back) == meaning(graph)
    return script


@pytest.mark.parametrize("path", [path for path in SHIPPED if name_of(path) not in REFUSED], ids=name_of)
def test_a_graph_that_ships_comes_back_as_it_was(path: Path, tmp_path: Path) -> None:
    graph, _ = resolved(path)
    back, text = again(graph, tmp_path)
    assert meaning(back) == meaning(graph)
    compile(text, "exported.py", "exec")


@pytest.mark.parametrize(
    "name", ["variables", "wheel_loop", "script_node", "typed_values", "camera_helpers", "compound"]
)
def test_an_imported_graph_is_exported_to_what_it_came_from(name: str, tmp_path: Path) -> None:
    (path,), _ = imported(SCRIPTS / f"{name}.py", tmp_path)
    graph, _ = resolved(path)
    assert meaning(again(graph, tmp_path)[0]) == meaning(graph)


@pytest.mark.parametrize("name", REFUSED)
def test_a_strict_export_refuses_what_isaac_sim_has_not_by_name(name: str) -> None:
    findings = Findings()
    assert write_script(resolved(ROOT / "graphs" / f"{name}.yaml")[0], findings, strict=True) == ""
    assert [(finding.code, finding.message) for finding in findings.items] == [
        ("G402", message) for message in REFUSED[name]
    ]
    assert all(finding.span is not None for finding in findings.items)


def kept(graph: Graph) -> dict[str, Any]:
    """What a graph means without the nodes and ports that Isaac Sim has not."""
    known = meaning(graph)
    own = {name for name, kind, _ in known["nodes"] if kind.startswith("graphengine.")}
    extra = {
        (name, field)
        for (name, *_), instance in zip(known["nodes"], graph.instances, strict=True)
        for field, port in instance.cls.fields.items()
        if port.extension
    }
    known["nodes"] = [
        (name, kind, {field: value for field, value in values.items() if (name, field) not in extra})
        for name, kind, values in known["nodes"]
        if name not in own
    ]
    known["wires"] = {
        (source, out, target, into)
        for source, out, target, into in known["wires"]
        if not {source, target} & own and not {(source, out), (target, into)} & extra
    }
    return {key: known[key] for key in ("at", "runs", "evaluator", "nodes", "wires", "variables")}


BRIDGES = {
    name: {("OnPlaybackTick", "tick", f"{state}{node}", "exec_in") for node in ("Truth", "PublishJoints")}
    for name, state in (
        ("base/ackermann", "State_"),
        ("base/differential", "State_"),
        ("base/mecanum", "State_"),
    )
}
"""Wires that execute the nodes which only the wheel odometry executes, and which need nothing else of it."""


@pytest.mark.parametrize("name", REFUSED)
def test_what_isaac_sim_has_not_is_a_comment_at_its_place_and_the_rest_comes_back(name: str, tmp_path: Path) -> None:
    graph, _ = resolved(ROOT / "graphs" / f"{name}.yaml")
    findings = Findings()
    write_script(graph, findings)
    assert {finding.code for finding in findings.items} == {"W303"}
    assert [finding.message.removesuffix("; it is left out of the script") for finding in findings.items] == REFUSED[
        name
    ]
    back, text = again(graph, tmp_path, whole=False)
    compile(text, "exported.py", "exec")
    expected, found = kept(graph), kept(back)
    assert found["wires"] == expected["wires"] | BRIDGES.get(name, set())
    assert {**found, "wires": None} == {**expected, "wires": None}
    code = "\n".join(line for line in text.splitlines() if not line.strip().startswith("# left out: "))
    assert "graphengine." not in code
    for message in REFUSED[name]:
        assert f": {message.partition(': ')[2]}" in text


LOST = """graph: g
at: /World/g
nodes:
  Tick: OnPlaybackTick
  Gap: {type: NearestRange, inputs: {sector: [0.0, 1.0]}}
  First: {type: ComputeWheelOdometry, inputs: {targetPrim: /World/robot}}
  Clock: {type: ROS2PublishClock, every: {ticks: 2}}
  Split: BreakVector3
  Odometry: {type: ComputeWheelOdometry, inputs: {targetPrim: /World/robot}}
  Speed: {type: ROS2PublishClock, inputs: {topicName: speed}}
connections:
  - Tick.tick -> First.execIn
  - First.execOut -> Odometry.execIn
  - Odometry.execOut -> Clock.execIn
  - Odometry.linearVelocity -> Split.tuple
  - Split.x -> Speed.timeStamp
  - Odometry.execOut -> Speed.execIn
layout: {Tick: [0, 0], Odometry: [200, 0]}
"""


def test_nodes_that_need_nothing_of_what_is_left_out_are_still_executed(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(LOST, encoding="utf-8")
    graph, _ = resolved(tmp_path / "g.yaml")
    back, text = again(graph, tmp_path, whole=False)
    assert [str(wire) for wire in back.exec_wires] == [
        "Tick.tick -> Clock_every.execIn",
        "Clock_every.execOut -> Clock.execIn",
    ]
    assert text.count("GetPrimAtPath") == 1


def test_a_bundle_is_named_as_omnigraph_names_it(tmp_path: Path) -> None:
    text = (
        "graph: events\nnodes:\n  Heard: {type: OnCustomEvent, inputs: {eventName: a}}\n"
        "  Send: {type: SendCustomEvent, inputs: {eventName: b}}\n"
        "connections: [Heard.execOut -> Send.execIn, Heard.bundle -> Send.bundle]\n"
    )
    assert '("Heard.outputs_bundle", "Send.inputs:bundle")' in there_and_back(text, tmp_path)


def test_between_numbered_outputs_there_is_none_missing(tmp_path: Path) -> None:
    text = """graph: graph
nodes: {Tick: OnPlaybackTick, Gate: Multigate, First: Counter, Last: Counter}
connections: [Tick.tick -> Gate.execIn, Gate.output0 -> First.execIn, Gate.output3 -> Last.execIn]
"""
    script = there_and_back(text, tmp_path)
    assert [n for n in range(5) if f'("Gate.outputs:output{n}", "execution")' in script] == [1, 2, 3]


def test_an_exported_script_that_is_run_builds_the_same(tmp_path: Path) -> None:
    graph, _ = resolved(ROOT / "graphs" / "tutorial" / "joint_states.yaml")
    script = tmp_path / "exported.py"
    script.write_text(write_script(graph, Findings()), encoding="utf-8")
    (path,), findings = imported(script, tmp_path, "--an-argument-makes-it-run")
    assert findings.items == []
    assert meaning(resolved(path)[0]) == meaning(graph)


OUTER = """graph: outer
at: /World/outer
runs: physics_step
evaluator: push
doc: 'It says "quoted" \\ things.'
variables: {speed: {type: double, default: 2.5}, where: {type: target, default: [/World/a, /World/b]}}
parameters: {topic: {type: string, default: clock}}
nodes:
  Tick: OnPhysicsStep
  Inner: {subgraph: inner.yaml}
  Inner_Scale: ConstantDouble
  Clock: {type: ROS2PublishClock, inputs: {topicName: $(topic)}}
connections:
  - Tick.deltaSimulationTime -> Inner.value
  - Tick.step -> Clock.execIn
  - Inner.result -> Clock.timeStamp
layout: {Tick: [0, -10.5], Clock: [200, 0]}
"""
INNER = """graph: inner
inputs: {value: Product.a}
outputs: {result: Product.product}
nodes:
  Scale: {type: ConstantDouble, inputs: {value: 3}}
  Product: Multiply
connections: [Scale.inputs:value -> Product.b]
"""


def test_subgraphs_are_expanded_and_parameters_filled_in(tmp_path: Path) -> None:
    (tmp_path / "outer.yaml").write_text(OUTER, encoding="utf-8")
    (tmp_path / "inner.yaml").write_text(INNER, encoding="utf-8")
    graph, told = resolved(tmp_path / "outer.yaml")
    assert told.items == []
    back, text = again(graph, tmp_path)
    one, other = meaning(graph), meaning(back)
    renamed = {"Inner_Scale_2" if n == "Inner_Scale" and v else n: v for n, _, v in one["nodes"]}
    assert {name: values for name, _, values in other["nodes"]} == renamed
    for key in ("at", "runs", "evaluator", "variables", "layout"):
        assert one[key] == other[key]
    assert "GRAPH_PIPELINE_STAGE_ONDEMAND" in text
    assert '("Clock.inputs:topicName", "clock")' in text
    assert 'usdrt.Sdf.Path("/World/a")' in text


def test_messages_are_named_before_their_fields_are_wired(tmp_path: Path) -> None:
    publisher = "P: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, messageName: Float64}}"
    text = f"graph: g\nnodes:\n  C: ConstantDouble\n  {publisher}\nconnections: ['C.inputs:value -> P.data']\n"
    first, second = there_and_back(text, tmp_path).split("og.Controller.edit(")[1:]
    assert '("P.inputs:messageName", "Float64")' in first
    assert "CONNECT" not in first
    assert '("C.inputs:value", "P.inputs:data")' in second


EVERY = """graph: g
at: /World/g
nodes:
  Tick: {type: OnTick, every: {ticks: 2}}
  Clock: {type: ROS2PublishClock, every: {ticks: 3}}
  Text: {type: PrintText, every: once, inputs: {text: begun}}
  Tick_every: ConstantDouble
connections:
  - Tick.tick -> Clock.execIn
  - Tick.tick -> Text.execIn
"""


def test_how_often_a_node_runs_becomes_the_gates_of_isaac_sim(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(EVERY, encoding="utf-8")
    back, _ = again(resolved(tmp_path / "g.yaml")[0], tmp_path)
    gate, once = "isaacsim.core.nodes.IsaacSimulationGate", "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame"
    types = {instance.id: instance.cls.type_name for instance in back.instances}
    assert [types[name] for name in ("Tick_every_2", "Clock_every", "Text_every")] == [gate, gate, once]
    assert [back.by_id(name).make_node().step for name in ("Tick_every_2", "Clock_every")] == [2, 3]  # type: ignore[attr-defined]
    assert [str(wire) for wire in back.exec_wires] == [
        "Tick.tick -> Tick_every_2.execIn",
        "Tick_every_2.execOut -> Clock_every.execIn",
        "Clock_every.execOut -> Clock.execIn",
        "Tick_every_2.execOut -> Text_every.execIn",
        "Text_every.step -> Text.execIn",
    ]


def test_how_often_a_node_runs_in_a_second_becomes_ticks_and_a_strict_export_refuses_it(tmp_path: Path) -> None:
    path = tmp_path / "g.yaml"
    path.write_text(
        "graph: g\nnodes:\n  Tick: {type: OnTick, every: {hz: 9}}\n  C: Counter\nconnections: [Tick.tick -> C.execIn]\n"
    )
    graph, findings, strict = resolved(path)[0], Findings(), Findings()
    assert '("Tick_every.inputs:step", 7),  # every: {hz: 9}' in write_script(graph, findings)
    assert write_script(graph, strict, strict=True) == ""
    message = "Tick: `every` has a rate in Hz, but the gates of Isaac Sim count ticks"
    assert [(one.code, one.message) for one in strict.items] == [("G402", message)]
    assert [(one.code, one.message) for one in findings.items] == [("W303", f"{message}; the script counts 7 ticks")]
    assert findings.items[0].help == ("write `every: {ticks: 7}`, which at 60 ticks a second is 8.57143 Hz",)


def _fixed(cls: type[Node]) -> bool:
    """Whether a type's ports are known without its values."""
    return cls.dynamic_ports.__func__ is Node.dynamic_ports.__func__  # type: ignore[attr-defined]


TWIST = {"messagePackage": "geometry_msgs", "messageSubfolder": "msg", "messageName": "Twist"}


def _grown(cls: type[Node]) -> type[Node]:
    """A type with the ports of a message where it has such, and with two numbered ones of each series."""
    numbers = [f"{series}{number}" for series in cls.numbered for number in (1, 3)]
    return grown(cls, {} if _fixed(cls) else TWIST, default_registry().definitions, numbers)


GENERIC = ("isaacsim.ros2.bridge.ROS2Publisher", "isaacsim.ros2.bridge.ROS2Subscriber")
CLASSES = [cls for cls in dict.fromkeys(default_registry().types.values()) if _fixed(cls) or cls.type_name in GENERIC]
CLASSES = [_grown(cls) for cls in CLASSES if not cls.type_name.startswith("graphengine.")]
CLASSES.sort(key=lambda cls: cls.type_name)
PATHS = st.from_regex(r"(/[A-Za-z_][A-Za-z0-9_]{0,8}){1,3}", fullmatch=True)
WIDTHS = {"half": 16, "float": 32}
RANGES = {"uchar": (0, 2**8 - 1), "int": (-(2**31), 2**31 - 1), "uint": (0, 2**32 - 1)}
RANGES |= {"int64": (-(2**63), 2**63 - 1), "uint64": (0, 2**64 - 1)}


def scalars(base: str) -> st.SearchStrategy[Any]:
    if base == "bool":
        return st.booleans()
    if base in RANGES:
        return st.integers(*RANGES[base])
    if base in ("half", "float", "double", "timecode"):
        return st.floats(allow_nan=False, width=WIDTHS.get(base, 64))  # type: ignore[arg-type]
    return st.text(st.characters(codec="utf-8"), max_size=8)


def values(port_type: PortType) -> st.SearchStrategy[Any]:
    """Legal values, as a file has them."""
    if port_type.base == "target":
        return st.lists(PATHS, max_size=3)
    one = scalars(port_type.base)
    one = st.lists(one, min_size=port_type.count, max_size=port_type.count) if port_type.count > 1 else one
    return st.lists(one, max_size=3) if port_type.array else one


@st.composite
def inputs(draw: st.DrawFn, cls: type[Node]) -> dict[str, Any]:
    """Values of some inputs, of numbered ones too; those of several types are written with one."""
    made: dict[str, Any] = dict(TWIST) if cls.type_name in GENERIC else {}
    ports = [port for port in cls.fields.values() if port.side == "inputs" and not port.is_exec and not port.extension]
    ports = [port for port in ports if port.name not in made]
    for port in draw(st.lists(st.sampled_from(ports), max_size=4, unique_by=lambda port: port.name)) if ports else []:
        made |= draw(one_input(port.name, port))
    return made


@st.composite
def one_input(draw: st.DrawFn, name: str, port: Port) -> dict[str, Any]:
    if isinstance(port.type, UnionType):
        chosen = draw(st.sampled_from([a for a in port.type.alternatives if a.base not in ("any", "bundle")]))
        value = draw(values(chosen))
        return {name: {"type": str(chosen), "value": value}} if not port.refusal(coerce(value, chosen)) else {}
    if port.type.base in ("any", "bundle") or port.type.role == "pointer":
        return {}
    value = draw(st.sampled_from(port.tokens) if port.tokens else values(port.type))
    try:
        port.check(value)
    except ValueError:
        return {}
    return {name: value}


@st.composite
def graphs(draw: st.DrawFn) -> str:
    """The text of a graph file whose wires join ports of equal types."""
    classes = draw(st.lists(st.sampled_from(CLASSES), min_size=1, max_size=5))
    nodes = {f"N{index}": {"type": cls.type_name, "inputs": draw(inputs(cls))} for index, cls in enumerate(classes)}
    starts = [(i, port) for i, cls in enumerate(classes) for port in cls.fields.values() if port.side == "outputs"]
    ends = [(i, port) for i, cls in enumerate(classes) for port in cls.fields.values() if port.side == "inputs"]
    wires, taken = [], set()
    for end, into in draw(st.lists(st.sampled_from(ends), max_size=6)) if ends else []:
        fitting = [(i, port) for i, port in starts if port.type == into.type and not isinstance(port.type, UnionType)]
        if fitting and ((end, into.name) not in taken or into.is_exec) and not into.extension:
            start, out = draw(st.sampled_from(fitting))
            if not out.extension:
                taken.add((end, into.name))
                wires.append(f"N{start}.outputs:{out.name} -> N{end}.inputs:{into.name}")
    speed = draw(values(PortType("double", 3)))
    variables = flow({"v": {"type": "double[3]", "default": speed}})
    lines = ["graph: g", "at: /World/g", f"variables: {variables}"]
    lines += ["nodes:", *(f"  {name}: {flow(node)}" for name, node in nodes.items())]
    return "\n".join([*lines, f"connections: {flow(list(dict.fromkeys(wires)))}", ""])


@settings(max_examples=150)
@given(graphs())
def test_a_random_graph_comes_back_as_it_was(text: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        there_and_back(text, Path(folder))
        graph, _ = resolved(Path(folder) / "graph.yaml")
    assert len(graph.instances) == text.count("\n  N")
    names_of_nothing = {"variable_name", "prim_path", "name"}  # no variable, prim or attribute has a random name
    assert not any(instance.refused - names_of_nothing for instance in graph.instances)
