"""Findings of the dry setup: the place of the input that asked, and no second finding that only follows from a first."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

SCENE = Path(__file__).parent / "cases" / "parts" / "rover_scene.yaml"
TICK = "  Tick: OnPlaybackTick\n"


def told(folder: Path, nodes: str, wires: str, *, scene: bool = False, **overrides: object) -> list[str]:
    """Code and underlined text of each error, or of each warning if there is none."""
    path = folder / "a.yaml"
    path.write_text(f"graph: g\nnodes:\n{TICK}{nodes}connections: [{wires}]\n")
    given = {name.replace("__", "."): value for name, value in overrides.items()}
    assembly = build.load(path, Options(scene=SCENE if scene else None, overrides=given))
    places = [(f.code, f.span) for f in assembly.findings.errors or assembly.findings.warnings if f.span]
    return [f"{c} {p.source.lines[p.line - 1][p.column - 1 : p.column - 1 + p.length]}" for c, p in places]


@pytest.mark.parametrize(
    ("inputs", "place"),
    [
        ("targetPrim: /rovr", "G301 /rovr"),
        ("targetPrim: [/rovr]", "G301 /rovr"),
        ("'inputs:targetPrim': /rovr", "G301 /rovr"),
        ("targetPrim: /rover, jointNames: [left_wheel_joint, arm]", "G303 arm"),
        ("targetPrim: /rover, 'inputs:jointNames': [arm]", "G303 arm"),
        ("targetPrim: /rover, jointIndices: [1, 7]", "G303 7"),
        ("robotPath: /rovr, targetPrim: /rover", "G301 /rovr"),
    ],
)
def test_a_setup_error_has_the_position_of_the_value(inputs: str, place: str, tmp_path: Path) -> None:
    node = f"  A: {{type: IsaacArticulationController, inputs: {{{inputs}}}}}\n"
    assert told(tmp_path, node, "Tick.tick -> A.execIn", scene=True) == [place]


def test_an_error_in_a_command_line_value_has_the_position_of_the_node(tmp_path: Path) -> None:
    node = "  A: {type: IsaacArticulationController, inputs: {targetPrim: /rover}}\n"
    assert told(tmp_path, node, "Tick.tick -> A.execIn", scene=True, A__jointNames=["arm"]) == ["G303 A"]


def test_an_error_in_a_wired_value_has_the_position_of_the_node(tmp_path: Path) -> None:
    controller = "{type: IsaacArticulationController, inputs: {targetPrim: /rovr}}"
    nodes = f"  A: {controller}\n  B: IsaacArticulationController\n"
    wires = "Tick.tick -> A.execIn, Tick.tick -> B.execIn, A.inputs:targetPrim -> B.targetPrim"
    assert told(tmp_path, nodes, wires, scene=True) == ["G301 /rovr"]  # B lacks only what A was told wrongly


def test_a_missing_input_is_reported_once(tmp_path: Path) -> None:
    assert told(tmp_path, "  A: IsaacComputeOdometry\n", "Tick.tick -> A.execIn") == ["G208 A"]


def test_other_errors_of_a_node_are_reported_beside_a_wrong_input(tmp_path: Path) -> None:
    nodes = "  A: {type: ROS2PublishClock, inputs: {timeStamp: now, topicName: 2 clocks}}\n"
    assert told(tmp_path, nodes, "Tick.tick -> A.execIn") == ["G211 now", "G304 2 clocks"]


def test_nodes_behind_a_refused_wire_are_not_reported_as_idle(tmp_path: Path) -> None:
    nodes = "  A: ROS2SubscribeTwist\n  B: ROS2PublishClock\n"
    assert told(tmp_path, nodes, "Tick.tock -> A.execIn, A.execOut -> B.execIn") == ["G204 Tick.tock"]
    assert told(tmp_path, nodes, "A.execOut -> B.execIn") == ["W101 A", "W101 B"]


@pytest.mark.parametrize("wire", ["Tick.tick => A.execIn", "Tick.tick -> A.execIn -> B.execIn", "Tick -> A.execIn"])
def test_nodes_behind_an_unreadable_wire_are_not_reported_as_idle(wire: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    nodes = "  A: ROS2SubscribeTwist\n  B: ROS2PublishClock\n  C: ROS2Context\n"
    wires = f"['{wire}', A.execOut -> B.execIn, C.context -> B.context]"
    path.write_text(f"graph: g\nnodes:\n{TICK}{nodes}connections: {wires}\n")
    assert [finding.code for finding in build.load(path).findings.items] == ["G202"]


@pytest.mark.parametrize(
    ("value", "underlined", "message"),
    [
        ("[left, 2]", "2", "A.jointNames[1] of a token[]: expected text, got 2"),
        ("[[left]]", "[", "A.jointNames[0] of a token[]: expected text, got a list"),
        ("left", "left", "A.jointNames is a token[]: expected a list of token, got 'left'"),
    ],
)
def test_an_error_in_a_list_has_the_position_of_the_element(
    value: str, underlined: str, message: str, tmp_path: Path
) -> None:
    node = f"  A: {{type: IsaacArticulationController, inputs: {{targetPrim: /rover, jointNames: {value}}}}}\n"
    assert told(tmp_path, node, "Tick.tick -> A.execIn") == [f"G211 {underlined}"]
    assert [finding.message for finding in build.load(tmp_path / "a.yaml").findings.errors] == [message]
