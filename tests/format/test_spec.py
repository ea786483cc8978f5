"""What the three kinds of file may hold: schemas, round trips, unknown keys at every level."""

from __future__ import annotations

import functools
import json
import pickle
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from graphengine.compiler.registry import default_registry
from graphengine.compiler.schema import make_schema
from graphengine.format import document, spec_reader
from graphengine.format.diagnostics import Findings
from graphengine.format.files import shipped
from graphengine.format.robot_spec import RobotSpec
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec import GraphSpec, Spec

SHIPPED = [path for folder in ("graphs", "scenes") for path in sorted((shipped() / folder).rglob("*.yaml"))]
FILES = [path for path in SHIPPED if not {"sensors", "scenarios"} & {*path.parts}]


def read(path: Path) -> tuple[str, Any]:
    """Kind and data of a file."""
    loaded = document.load(path, Findings())
    assert loaded is not None
    kind = spec_reader.kind_of(loaded)
    assert kind is not None
    return kind, loaded.data


def shown(path: Path) -> str:
    return str(path.relative_to(shipped()))


def told(model: type[Spec], text: str) -> list[str]:
    """`line:column message; help` of each finding."""
    findings = Findings()
    parsed = document.parse(text, "a.yaml", findings)
    assert parsed is not None
    spec_reader.validate(model, parsed, parsed.data, findings)
    return [
        f"{item.span.line}:{item.span.column} {'; '.join([item.message, *item.help])}"
        for item in findings.sorted()
        if item.span is not None
    ]


@functools.cache
def validator(kind: str) -> jsonschema.Draft202012Validator:
    schema = json.loads(json.dumps(make_schema(kind, default_registry())))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_files_of_every_kind_are_included() -> None:
    assert {read(path)[0] for path in FILES} == {"graph", "scene", "robot"}


@pytest.mark.parametrize("path", FILES, ids=shown)
def test_the_printed_schema_accepts_all_shipped_files(path: Path) -> None:
    kind, data = read(path)
    validator(kind).validate(data)


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("graph", {"graph": "g", "conections": []}),
        ("graph", {"graph": "g", "nodes": {"A": {"type": "OnPlaybackTick", "input": {}}}}),
        ("graph", {"graph": "g", "nodes": {"A": {"type": "ROS2SubscribeTwist", "inputs": {"topic": "a"}}}}),
        ("graph", {"graph": "g", "nodes": {"A": {"type": "SubscribeTwist", "inputs": {"timeout": -1.0}}}}),
        ("graph", {"graph": "2g"}),
        ("graph", {"format": 2, "graph": "g"}),
        ("graph", {"graph": "g", "runs": "often"}),
        ("scene", {"scene": "s"}),
        ("scene", {"scene": "s", "world": "w.xml", "physics": {"tick_rate": 0}}),
        ("scene", {"scene": "s", "world": "w.xml", "robots": {"r": {"use": "r.yaml", "position": [0, 0]}}}),
        ("robot", {"robot": "r", "joints": {"j": {"drive": {"damping": -1.0}}}}),
    ],
)
def test_the_schema_refuses_what_check_refuses(kind: str, data: dict[str, Any]) -> None:
    assert not validator(kind).is_valid(data)


@pytest.mark.parametrize("path", FILES, ids=shown)
def test_specs_survive_pickling(path: Path) -> None:
    kind, _ = read(path)
    findings = Findings()
    loaded = spec_reader.read(spec_reader.KINDS[kind], path, findings)
    assert not findings.items
    assert loaded is not None
    again = pickle.loads(pickle.dumps(loaded.spec))
    assert again == loaded.spec
    assert type(again) is type(loaded.spec)
    assert again.model_dump_json() == loaded.spec.model_dump_json()


def test_specs_are_frozen() -> None:
    graph = GraphSpec(graph="g")
    with pytest.raises(ValueError, match="frozen"):
        graph.doc = "changed"


GRAPH, SCENE, ROBOT = "graph: g\n", "scene: s\nworld: w\n", "robot: r\n"
USD_DRIVE = "keys: damping, stiffness, target_velocity, max_force, overtravel"
FRICTIONS = "did you mean 'direction' or 'static_friction' or 'dynamic_friction'?"
QUATERNION = "did you mean 'quaternion_xyzw'?"
MODELS: dict[str, type[Spec]] = {GRAPH: GraphSpec, SCENE: SceneSpec, ROBOT: RobotSpec}


@pytest.mark.parametrize(
    ("head", "text", "place", "key", "help"),
    [
        (GRAPH, "node: {}", "2:1", "node", "did you mean 'nodes'?"),
        (GRAPH, "nodes: {A: {typ: OnPlaybackTick, type: x}}", "2:13", "typ", "did you mean 'type'?"),
        (GRAPH, "parameters: {a: {type: double, defalt: 1.0}}", "2:32", "defalt", "did you mean 'default'?"),
        (GRAPH, "variables: {a: {type: double, value: 1.0}}", "2:31", "value", "keys: type, default, doc"),
        (SCENE, "physics: {substep: 1}", "3:11", "substep", "did you mean 'substeps'?"),
        (SCENE, "robots: {x: {use: r, orientation: {rpy_rad: [0]}}}", "3:36", "rpy_rad", "did you mean 'rpy_deg'?"),
        (SCENE, "robots: {x: {use: r, namspace: a}}", "3:22", "namspace", "did you mean 'namespace'?"),
        (SCENE, "graphs: {x: {use: r, parameter: {}}}", "3:22", "parameter", "did you mean 'parameters'?"),
        (ROBOT, "joint: {}", "2:1", "joint", "did you mean 'joints'?"),
        (ROBOT, "joints: {j: {drive: {dampening: 1.0}}}", "2:22", "dampening", "did you mean 'damping'?"),
        (ROBOT, "joints: {j: {usd_drive: {max_acceleration: 1}}}", "2:26", "max_acceleration", USD_DRIVE),
        (ROBOT, "materials: {m: {friction: 1.0}}", "2:17", "friction", FRICTIONS),
        (ROBOT, "frames: {f: {parent: a, orientation: {quaternion: []}}}", "2:39", "quaternion", QUATERNION),
        (ROBOT, "sensors: {s: {type: lidar, parent: a, noise: 1.0}}", "2:39", "noise", "did you mean 'noise_std'?"),
    ],
)
def test_unknown_keys_are_reported_at_every_level(head: str, text: str, place: str, key: str, help: str) -> None:
    assert f"{place} unknown key {key!r}; {help}" in told(MODELS[head], head + text)


TURNED = f"{SCENE}robots:\n  r:\n    use: r.yaml\n    orientation: "
ORIENTATION = (
    "Orientation of the robot in the world: `{rpy_deg: [roll, pitch, yaw]}` or `{quaternion_xyzw: [x, y, z, w]}`."
)
BOTH = "6:5 orientation: give either rpy_deg: [roll, pitch, yaw] or quaternion_xyzw: [x, y, z, w]"


@pytest.mark.parametrize(
    ("orientation", "message"),
    [
        ("{}", BOTH),
        ("{rpy_deg: [0, 0, 0], quaternion_xyzw: [0, 0, 0, 1]}", BOTH),
        ("[0, 0, 90]", "6:18 orientation: expected a mapping, got a list; " + ORIENTATION),
        ("90", "6:18 orientation: expected a mapping, got 90; " + ORIENTATION),
        ("{rpy_deg: 90}", "6:28 rpy_deg: expected a list, got 90; Roll, pitch and yaw, degrees."),
        ("{rpy_deg: [0, 0]}", "6:28 rpy_deg: expected 3 values, got 2"),
        ("{quaternion_xyzw: [0, 0, 1]}", "6:36 quaternion_xyzw: expected 4 values, got 3"),
        ("{rpy_deg: [0, 0, 0, 1]}", "6:28 rpy_deg: expected 3 values, got 4; Roll, pitch and yaw, degrees."),
        ("{rpy_deg: [0, 0, north]}", "6:35 rpy_deg[2]: expected a number, got 'north'"),
        ("{rpy_deg: [0, 0, true]}", "6:35 rpy_deg[2]: expected a number, got true"),
        ("{rpy_deg: [0, 0, .inf]}", "6:35 rpy_deg[2]: expected a finite number, got inf"),
    ],
)
def test_illegal_orientations_are_refused(orientation: str, message: str) -> None:
    assert told(SceneSpec, TURNED + orientation) == [message]


def test_both_orientations_are_accepted() -> None:
    assert told(SceneSpec, TURNED + "{rpy_deg: [0, 0.5, 90]}") == []
    assert told(SceneSpec, TURNED + "{quaternion_xyzw: [0, 0, 0, 1]}") == []


def test_all_errors_of_a_file_are_reported_together() -> None:
    text = (
        f"{GRAPH}runs: often\nnodes: {{a-b: x, C: {{}}, D: 5}}\nconnections: [1, [x]]\nlayout: {{A: [1]}}\nextra: 1\n"
    )
    assert len(told(GraphSpec, text)) == 8


@pytest.mark.parametrize("path", ["/dd 100/drive", "/dd100/drive\u00a02", "/dd100/../x"])
def test_an_illegal_prim_path_is_refused(path: str) -> None:
    (message,) = told(GraphSpec, f"graph: g\nat: {path}\n")
    assert message.startswith("2:5 at: a prim path cannot contain ")


@pytest.mark.parametrize("number", ["1", "1.0", "true", "'1'"])
def test_the_format_is_the_number_one(number: str) -> None:
    assert bool(told(GraphSpec, f"format: {number}\ngraph: g\n")) is (number != "1")


def test_a_newer_format_is_one_error() -> None:
    text = "format: 2\ngraph: {name: g}\nwires: []\nnodes: 5\n"
    (message,) = told(GraphSpec, text)
    assert message == (
        "1:9 format 2 is not supported; "
        "this version reads format 1; a file with a higher number needs a newer graphengine"
    )


def test_layout_is_read() -> None:
    assert told(GraphSpec, "graph: g\nlayout: {A: [10, 20.5]}\n") == []
