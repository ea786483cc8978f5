"""What an import says of node types that are not available, and how it carries older ones over."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from graphengine.cli import main
from graphengine.compiler.registry import default_registry
from graphengine.format.diagnostics import Findings
from graphengine.isaac import node_replacements
from graphengine.isaac.recorded_graph import RecordedNode, RecordedValue
from tests.isaac.harness import composed, graph

TYPES = (Path(__file__).parent / "isaac_types.txt").read_text("utf-8").split()
"""Registered names of all node types in the extensions of Isaac Sim 6.0.1."""


def imported(node: RecordedNode) -> tuple[str, Findings]:
    return composed(graph(node))


@pytest.mark.parametrize(
    ("type_name", "words"),
    [
        ("omni.isaac.core_nodes.IsaacGenerateRGBA", "ROS2CameraHelper"),
        ("omni.isaac.ros_bridge.ROS1PublishTransformTree", "the node of the same name with ROS2"),
        ("isaacsim.ucx.nodes.UCXPublishClock", "ROS2PublishClock"),
        ("omni.graph.ui_nodes.OnWidgetClicked", "graphrun ctl impulse"),
    ],
)
def test_a_type_that_is_not_available_is_told_with_what_does_its_work(type_name: str, words: str) -> None:
    text, findings = imported(RecordedNode("N", type_name))
    (finding,) = [one for one in findings.items if one.code == "W301"]
    assert words in finding.help[0]
    assert type_name in text


def missing() -> list[str]:
    """Isaac Sim's node types that are not built here; those of its extension template have `<extension>` for its name."""
    return [name for name in TYPES if default_registry().find(name) is None]


def test_isaac_sim_has_these_types_and_most_of_them_are_available() -> None:
    assert len(TYPES) == len(set(TYPES)) == 116
    assert len(missing()) < 40


def test_no_type_of_isaac_sim_is_unknown_without_a_word() -> None:
    assert [name for name in missing() if not node_replacements.replacement(name)] == []


@pytest.mark.parametrize("name", missing())
def test_the_command_line_says_what_takes_the_place_of_a_missing_type(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for spelling in (name, name.rpartition(".")[2]):
        assert main(["nodes", spelling]) == 2
        error = capsys.readouterr().err
        assert f"{spelling!r} of Isaac Sim is not available; {node_replacements.replacement(name)}" in error


@pytest.mark.parametrize("name", missing())
def test_an_import_says_what_takes_the_place_of_a_missing_type(name: str) -> None:
    _, findings = imported(RecordedNode("N", name))
    (finding,) = [one for one in findings.items if one.code == "W301"]
    assert finding.help[0] == node_replacements.replacement(name)


def test_every_node_that_is_named_as_a_replacement_is_available() -> None:
    advice = " ".join((*node_replacements.REPLACEMENTS.values(), *node_replacements.FAMILIES.values()))
    named = set(re.findall(r"\b(?:ROS2|Isaac|Write|On|Random)[A-Z][A-Za-z0-9]+", advice))
    assert {"ROS2CameraHelper", "ROS2PublishClock", "WritePrimAttribute"} < named
    assert [name for name in sorted(named) if default_registry().find(name) is None] == []
    assert [name for name in node_replacements.REPLACEMENTS if default_registry().find(name) is not None] == []


@pytest.mark.parametrize("topic", [{"inputs:topicName": RecordedValue("info")}, {}])
def test_a_camera_helper_of_type_camera_info_becomes_the_helper_that_publishes_it(
    topic: dict[str, RecordedValue],
) -> None:
    values = {"inputs:type": RecordedValue("camera_info"), "inputs:frameId": RecordedValue("eye"), **topic}
    text, findings = imported(RecordedNode("Info", "omni.isaac.ros2_bridge.ROS2CameraHelper", values))
    assert "type: isaacsim.ros2.bridge.ROS2CameraInfoHelper" in text
    assert "camera_info" not in text
    (note,) = [one for one in findings.items if one.code == "N301"]
    assert note.help == (() if topic else ("its topic is camera_info, because topicName is not set",))


def test_a_camera_helper_of_another_type_stays_one() -> None:
    values = {"inputs:type": RecordedValue("depth")}
    text, findings = imported(RecordedNode("Depth", "isaacsim.ros2.bridge.ROS2CameraHelper", values))
    assert "inputs: {type: depth}" in text
    assert findings.items == []
