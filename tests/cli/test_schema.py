"""`graphrun schema`: JSON Schema that editors complete and underline with."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from tests.cli.harness import ROOT, Graphrun, process

KINDS = ("graph", "scene", "robot")


@functools.cache
def schema(kind: str) -> dict[str, Any]:
    result = process("schema", kind, code=0, err="")
    made: dict[str, Any] = json.loads(result.out)
    return made


@functools.cache
def shipped(kind: str) -> list[Path]:
    """Files of a kind: the one whose naming key they have first."""
    found = []
    for path in sorted([*(ROOT / "graphs").rglob("*.yaml"), *(ROOT / "scenes").rglob("*.yaml")]):
        keys = yaml.safe_load(path.read_text(encoding="utf-8"))
        if "scenario" not in keys and next((one for one in KINDS if one in keys), None) == kind:
            found.append(path)
    return found


def faults(kind: str, data: Any) -> list[str]:
    return [error.json_path for error in Draft202012Validator(schema(kind)).iter_errors(data)]


def graph_with(node: Any) -> dict[str, Any]:
    return {"graph": "g", "nodes": {"Node": node}}


@pytest.mark.parametrize("kind", KINDS)
def test_each_schema_is_a_json_schema_of_2020_12(kind: str) -> None:
    assert schema(kind)["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    Draft202012Validator.check_schema(schema(kind))


@pytest.mark.parametrize("kind", KINDS)
def test_each_schema_accepts_all_shipped_files(kind: str) -> None:
    files = shipped(kind)
    assert files
    assert {str(path): faults(kind, yaml.safe_load(path.read_text(encoding="utf-8"))) for path in files} == {
        str(path): [] for path in files
    }


@pytest.mark.parametrize("kind", KINDS)
def test_a_misspelt_key_is_rejected(kind: str) -> None:
    data = yaml.safe_load(shipped(kind)[0].read_text(encoding="utf-8"))
    assert faults(kind, {**data, "formt": 1}) == ["$"]


@pytest.mark.parametrize("name", ["ROS2SubscribeTwist", "SubscribeTwist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"])
def test_port_names_are_completed_for_every_spelling_of_a_type_and_wrong_ones_rejected(name: str) -> None:
    assert faults("graph", graph_with({"type": name, "inputs": {"topicName": "cmd_vel"}})) == []
    assert faults("graph", graph_with({"type": name, "inputs": {"topicname": "cmd_vel"}})) == ["$.nodes.Node"]
    assert faults("graph", graph_with({"type": name, "inputs": {"execIn": 1}})) == ["$.nodes.Node"]


@pytest.mark.parametrize(
    ("inputs", "legal"),
    [
        ({"timeout": 0.5}, True),
        ({"timeout": 1}, True),
        ({"timeout": "$(t)"}, True),
        ({"timeout": "half a second"}, False),
        ({"timeout": -1}, False),
        ({"inputs:timeout": 0.5}, True),
        ({"inputs:timeot": 0.5}, False),
        ({"topicName": "$(robot)_cmd_vel"}, True),
        ({"topicName": 5}, False),
        ({"queueSize": 1.5}, False),
    ],
)
def test_values_are_those_that_the_engine_takes(inputs: dict[str, Any], legal: bool) -> None:
    assert (faults("graph", graph_with({"type": "SubscribeTwist", "inputs": inputs})) == []) is legal


@pytest.mark.parametrize(
    ("value", "legal"),
    [([1, 2.5, 0], True), (["$(x)", 0, 0], True), ("$(position)", True), ([1, 2], False), (["a", 0, 0], False)],
)
def test_a_vector_has_its_length_and_may_hold_parameters(value: Any, legal: bool) -> None:
    node = {"type": "PublishRawTransformTree", "inputs": {"translation": value}}
    assert (faults("graph", graph_with(node)) == []) is legal


@pytest.mark.parametrize(("value", "legal"), [([0.1, 0.0], True), ([0.1, -0.1], False), (["$(x)", 0.1], True)])
def test_the_bounds_of_a_vector_are_those_of_its_numbers(value: Any, legal: bool) -> None:
    node = {"type": "CheckGoal2D", "inputs": {"thresholds": value}}
    assert (faults("graph", graph_with(node)) == []) is legal


def test_the_schema_lists_the_tokens_of_a_port() -> None:
    def typed(value: str) -> list[str]:
        return faults("graph", graph_with({"type": "RtxLidarHelper", "inputs": {"type": value}}))

    assert typed("point_cloud") == typed("$(kind)") == []
    assert typed("pointcloud") == ["$.nodes.Node"]


def test_illegal_names_of_nodes_and_robots_are_refused() -> None:
    assert faults("graph", {"graph": "g", "nodes": {"a-b": "OnPlaybackTick"}}) != []
    assert faults("scene", {"scene": "s", "world": "w.xml", "robots": {"r-1": {"use": "r.yaml"}}}) != []


@pytest.mark.parametrize(
    ("kind", "key"), [(kind, key) for kind in KINDS for key in yaml.safe_load(shipped(kind)[0].read_text("utf-8"))]
)
def test_a_value_of_a_wrong_type_is_refused_by_schema_and_check_alike(
    graphrun: Graphrun, project: Path, kind: str, key: str
) -> None:
    data = {**yaml.safe_load(shipped(kind)[0].read_text("utf-8")), key: 3.5}
    (project / "changed.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    scene = "scene: s\nworld: worlds/flat_grid.xml\nrobots: {r: {use: changed.yaml}}\n"
    (project / "scene.yaml").write_text(scene, encoding="utf-8")
    assert f"$.{key}" in faults(kind, data)
    result = graphrun("check", "scene.yaml" if kind == "robot" else "changed.yaml", code=1)
    assert re.search(rf"^changed\.yaml:\d+:\d+: error G10[89]: {key}: ", result.out, re.MULTILINE)
