"""One mistake is one finding, told where it was made, and what follows from it is not told as well."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.format.diagnostics import Source, Span
from graphengine.scene import build

NOWHERE = Span(Source("", ()), 0, 0)
WORLD = '<mujoco><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'
TICK = "graph: g\nnodes:\n  Tick: OnPlaybackTick\n"
ROBOT = "graph: g\nparameters: {robot: {type: target, default: /rover}}\nnodes:\n  Tick: OnPlaybackTick\n"
PUBLISH = "connections: [Tick.tick -> A.execIn]\n"


def told(folder: Path, text: str) -> list[str]:
    """Code, file and line of each error."""
    path = folder / "a.yaml"
    path.write_text(text)
    assembly = build.load(path)
    spans = [(finding.code, finding.span or NOWHERE) for finding in assembly.findings.errors]
    return [f"{code} {Path(span.source.path).name}:{span.line}" for code, span in spans]


# Parameters


@pytest.mark.parametrize("default", ["1", "{a: 1}", "[1]", "[[]]"])
def test_a_target_parameter_whose_default_is_no_path(default: str, tmp_path: Path) -> None:
    text = f"graph: g\nparameters: {{robot: {{type: target, default: {default}}}}}\nnodes:\n  Tick: OnPlaybackTick\n"
    assert told(tmp_path, text) == ["G211 a.yaml:2"]


def test_a_required_input_from_a_parameter_that_has_no_value(tmp_path: Path) -> None:
    text = "graph: g\nparameters: {robot: {type: target, default: 1}}\nnodes:\n  Tick: OnPlaybackTick\n"
    use = "  A: {type: IsaacComputeOdometry, inputs: {chassisPrim: $(robot)}}\n"
    assert told(tmp_path, f"{text}{use}{PUBLISH}") == ["G211 a.yaml:2"]


@pytest.mark.parametrize("parameter", ["{type: prim}", "{type: double}", "{type: double, default: x}"])
def test_uses_of_a_parameter_that_has_no_value(parameter: str, tmp_path: Path) -> None:
    node = "  A: {type: ROS2PublishClock, inputs: {timeStamp: $(p), topicName: t$(p)}}\n"
    text = f"graph: g\nparameters: {{p: {parameter}}}\nnodes:\n  Tick: OnPlaybackTick\n{node}{PUBLISH}"
    assert [place.partition(" ")[2] for place in told(tmp_path, text)] == ["a.yaml:2"]


def test_the_parameters_of_a_newer_format(tmp_path: Path) -> None:
    assert told(tmp_path, "format: 2\ngraph: g\nparameters: {robot: {type: prim}}\n") == ["G110 a.yaml:1"]


@pytest.mark.parametrize(
    ("kind", "inputs"),
    [
        ("IsaacComputeOdometry", "{chassisPrim: $(robt)}"),
        ("IsaacComputeOdometry", "{chassisPrim: [$(robt), /x]}"),
        ("ROS2PublishClock", "{topicName: $(robt)}"),
        ("ROS2PublishClock", "{topicName: $(robt)/clock}"),
        ("ROS2PublishClock", "{topicName: clock/$(robt)}"),
        ("ROS2PublishClock", "{timeStamp: $(robt)}"),
        ("BreakVector3", "{tuple: $(robt)}"),
        ("BreakVector3", "{tuple: {type: 'double[3]', value: $(robt)}}"),
    ],
)
def test_an_unknown_parameter(kind: str, inputs: str, tmp_path: Path) -> None:
    node = f"  A: {{type: {kind}, inputs: {inputs}}}\n  Clock: ROS2PublishClock\n"
    wire = "A.x -> Clock.timeStamp" if kind == "BreakVector3" else "Tick.tick -> A.execIn"
    text = f"{ROBOT}{node}connections: [Tick.tick -> Clock.execIn, {wire}]\n"
    assert told(tmp_path, text) == ["G111 a.yaml:5"]


@pytest.mark.parametrize(
    "line", ["runs: $(x)", "at: $(x)/drive", "doc: $(x)", "variables: {v: {type: int, default: $(x)}}"]
)
def test_an_unknown_parameter_outside_of_the_nodes(line: str, tmp_path: Path) -> None:
    assert told(tmp_path, f"graph: g\n{line}\n") == ["G111 a.yaml:2"]


def scene(folder: Path, parameters: str) -> str:
    (folder / "w.xml").write_text(WORLD)
    (folder / "g.yaml").write_text("graph: g\nparameters: {rate: {type: double}}\n")
    return f"scene: s\nworld: w.xml\ngraphs:\n  drive:\n    use: g.yaml\n    parameters:\n      {parameters}\n"


@pytest.mark.parametrize(
    ("parameters", "places"),
    [
        ("rate: 10.0", []),
        ("rate: fast", ["G211 a.yaml:7"]),
        ("{rate: 1.0, raet: 1.0}", ["G111 a.yaml:7"]),
        ("{}", ["G107 a.yaml:5"]),
    ],
)
def test_an_error_in_a_scenes_parameter_is_reported_in_the_scene(
    parameters: str, places: list[str], tmp_path: Path
) -> None:
    assert told(tmp_path, scene(tmp_path, parameters)) == places


# Subgraphs


@pytest.mark.parametrize("subgraph", [None, "graph: [\n", "graph: s\nnodes: 1\n"])
def test_wires_to_a_subgraph_that_cannot_be_opened(subgraph: str | None, tmp_path: Path) -> None:
    if subgraph is not None:
        (tmp_path / "s.yaml").write_text(subgraph)
    text = f"{TICK}  Sub: {{subgraph: s.yaml}}\n  A: ROS2PublishClock\n"
    (only,) = told(tmp_path, f"{text}connections: [Tick.tick -> Sub.execIn, Sub.execOut -> A.execIn]\n")
    assert only.startswith("G214 a.yaml:4" if subgraph is None else "G10")


# Inputs


@pytest.mark.parametrize(
    ("kind", "inputs", "code"),
    [
        ("IsaacComputeOdometry", "chassisPrim: 5", "G211"),
        ("IsaacComputeOdometry", "chasisPrim: /rover", "G204"),
        ("DifferentialController", "wheelRadius: 0.1", "G208"),
    ],
    ids=["of a wrong type", "misspelt", "missing beside another"],
)
def test_a_required_input(kind: str, inputs: str, code: str, tmp_path: Path) -> None:
    text = f"{TICK}  A: {{type: {kind}, inputs: {{{inputs}}}}}\n{PUBLISH}"
    assert told(tmp_path, text) == [f"{code} a.yaml:4"]


@pytest.mark.parametrize("helper", ["ROS2CameraHelper", "ROS2CameraInfoHelper", "ROS2RtxLidarHelper"])
def test_a_required_path_in_a_scene(helper: str, tmp_path: Path) -> None:
    (tmp_path / "w.xml").write_text(WORLD)
    (tmp_path / "s.yaml").write_text("scene: s\nworld: w.xml\n")
    text = f"graph: g\nscene: s.yaml\nnodes:\n  Tick: OnPlaybackTick\n  A: {helper}\n{PUBLISH}"
    assert told(tmp_path, text) == ["G208 a.yaml:5"]


@pytest.mark.parametrize(("inputs", "code"), [("{}", "G208"), ("{tuple: x}", "G211"), ("{tupl: [1, 2, 3]}", "G204")])
def test_a_required_input_of_several_types(inputs: str, code: str, tmp_path: Path) -> None:
    text = f"{TICK}  B: {{type: BreakVector3, inputs: {inputs}}}\n  A: ROS2PublishClock\n"
    wires = "connections: [Tick.tick -> A.execIn, B.x -> A.timeStamp]\n"
    assert told(tmp_path, f"{text}{wires}") == [f"{code} a.yaml:4"]


def test_a_refused_wire_determines_no_type_and_is_reported_once(tmp_path: Path) -> None:
    text = f"{TICK}  B: BreakVector3\n  A: ROS2PublishClock\n"
    wires = "connections: [Tick.tick -> A.execIn, Tick.tim -> B.tuple, B.x -> A.timeStamp]\n"
    assert told(tmp_path, f"{text}{wires}") == ["G204 a.yaml:6"]


# Variables and attributes, whose types nodes have for their own

VARIABLE = "graph: g\nvariables: {speed: {type: double, default: 1.0}}\nnodes:\n  Tick: OnPlaybackTick\n"
READING = "  Sum: {type: Add, inputs: {b: 1.0}}\n  A: ROS2PublishClock\n"
READ_ON = "connections: [Tick.tick -> A.execIn, Read.value -> Sum.a, Sum.sum -> A.timeStamp]\n"


@pytest.mark.parametrize(
    ("inputs", "code"), [("{variableName: sped}", "G307"), ("{}", "G208"), ("{variablName: speed}", "G204")]
)
def test_a_variable_that_is_read_by_a_wrong_name(inputs: str, code: str, tmp_path: Path) -> None:
    text = f"{VARIABLE}  Read: {{type: ReadVariable, inputs: {inputs}}}\n{READING}{READ_ON}"
    assert told(tmp_path, text) == [f"{code} a.yaml:5"]


def test_a_variable_that_is_written_by_a_wrong_name(tmp_path: Path) -> None:
    text = f"{VARIABLE}  A: {{type: WriteVariable, inputs: {{variableName: sped, value: 2}}}}\n"
    wires = "connections: [Tick.tick -> A.execIn, A.value -> B.timeStamp, Tick.tick -> B.execIn]\n"
    assert told(tmp_path, f"{text}  B: ROS2PublishClock\n{wires}") == ["G307 a.yaml:5"]


@pytest.mark.parametrize(("kind", "outcome"), [("duble", "type"), ("double", "default")])
def test_a_variable_with_an_error_exists_for_its_readers(kind: str, outcome: str, tmp_path: Path) -> None:
    text = f"{VARIABLE}  Read: {{type: ReadVariable, inputs: {{variableName: speed}}}}\n{READING}{READ_ON}"
    text = text.replace("double", kind).replace("1.0}}\nn", "fast}}\nn" if outcome == "default" else "1.0}}\nn")
    assert told(tmp_path, text) == ["G211 a.yaml:2"]


def test_an_unknown_variable_is_reported_with_a_similar_name(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"{VARIABLE}  Read: {{type: ReadVariable, inputs: {{variableName: sped}}}}\n{READING}{READ_ON}")
    (finding,) = build.load(path).findings.errors
    assert finding.message == "Read: the graph has no variable 'sped'"
    assert finding.help == ("did you mean 'speed'?",)
    assert finding.span is not None
    assert (finding.span.line, finding.span.column) == (5, 53)


def test_a_wire_to_the_name_of_a_variable_leaves_its_type_open(tmp_path: Path) -> None:
    text = f"{VARIABLE}  Read: ReadVariable\n  Name: {{type: ConstantToken, inputs: {{value: speed}}}}\n{READING}"
    wires = READ_ON.replace("[", "[Name.value -> Read.variableName, ")
    assert told(tmp_path, text + wires) == ["G213 a.yaml:9"]


@pytest.mark.parametrize("verb", ["ReadPrimAttribute", "WritePrimAttribute"])
def test_an_attribute_by_a_wrong_name(verb: str, tmp_path: Path) -> None:
    inputs = "{prim: /rover, name: 'xformOp:tranlsate'}"
    text = f"{TICK}  A: {{type: {verb}, inputs: {inputs}}}\n  B: ROS2PublishOdometry\n"
    wires = "Tick.tick -> B.execIn, A.value -> B.position"
    if verb == "WritePrimAttribute":
        text, wires = text.replace("name", "value: [1.0, 2.0, 3.0], name"), "Tick.tick -> A.execIn"
    assert told(tmp_path, f"{text}connections: [{wires}]\n") == ["G307 a.yaml:4"]


def test_a_value_that_decides_a_type_and_is_not_legal(tmp_path: Path) -> None:
    array = "{type: ConstructArray, inputs: {arrayType: 'doubl[]', input0: 1, input1: a}}"
    text = f"{TICK}  Make: {array}\n  A: {{type: ArticulationController, inputs: {{robotPath: /rover}}}}\n"
    wires = "connections: [Tick.tick -> A.execIn, Make.array -> A.velocityCommand]\n"
    assert told(tmp_path, text + wires) == ["G212 a.yaml:4"]


# Files


@pytest.mark.parametrize(
    ("scene", "told_at"),
    [
        ("robots: {r: {use: graph.yaml}}", "G107 graph.yaml:1"),
        ("robots: {r: {use: a.yaml}}", "G107 a.yaml:1"),
        ("graphs: {g: {use: robot.yaml}}", "G107 robot.yaml:2"),
    ],
)
def test_a_file_of_another_kind(scene: str, told_at: str, tmp_path: Path) -> None:
    (tmp_path / "graph.yaml").write_text("graph: g\nat: /g\nnodes: {T: OnTick}\nconnections: []\n")
    (tmp_path / "robot.yaml").write_text("format: 1\nrobot: r\nurdf: r.urdf\nbase_link: base\n")
    (tmp_path / "world.xml").write_text(WORLD)
    assert told(tmp_path, f"scene: s\nworld: world.xml\n{scene}\n") == [told_at]


def test_a_graph_file_that_names_its_scene_but_not_itself(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text("scene: s\nworld: world.xml\ngraphs: {g: {use: graph.yaml}}\n")
    (tmp_path / "world.xml").write_text(WORLD)
    (tmp_path / "graph.yaml").write_text("scene: scene.yaml\nnodes: {T: OnTick}\n")
    assembly = build.load(tmp_path / "scene.yaml")
    assert [finding.message for finding in assembly.findings.errors] == ["missing key 'graph'"]
