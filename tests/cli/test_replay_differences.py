"""`graphrun replay`: the first thing that is not the same."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from graphengine.compiler.registry import default_registry
from graphengine.node import Context, Node
from graphengine.scene.loaded_scene import Options
from tests.cli.harness import Graphrun
from tests.recording.harness import CLOCK, CMD_VEL, DRIVE, GOODBYE, NOISY_ROBOT, NOISY_SCENE, put, record, rewritten

FIXED = "{type: ReadSimulationTime, inputs: {referenceTimeNumerator: 5, referenceTimeDenominator: 2}}"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("Simulation Stop", "Simulation Start", "different in tick 1, t = 0.016667 s: /stopped"),
        ("topicName: closed", "topicName: bye", "different at the end, after tick 10, t = 0.166667 s: /bye"),
    ],
)
def test_a_different_end_of_the_run_is_reported(
    graphrun: Graphrun, tmp_path: Path, old: str, new: str, expected: str
) -> None:
    path = put(tmp_path / "hall" / "graph.yaml", GOODBYE)
    record(tmp_path / "out.mcap", 10, path)
    path.write_text(GOODBYE.replace(old, new), "utf-8")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(path), code=1)
    assert result.lines[0] == expected


def test_another_value_is_found_at_the_tick_after_the_first_command(graphrun: Graphrun, drive: Path) -> None:
    result = graphrun("replay", str(drive), "--set", "*DiffController.wheelRadius=0.05", code=1, err="")
    # The command is seen in tick 7, and the joints turn in the substeps of tick 8.
    assert min(DRIVE) == 7
    where, by, *fields, before = result.lines
    assert where == "different in tick 8, t = 0.133333 s: /dd100_0000/platform/joint_states"
    node = "/dd100/Geometry/base_link/chassis_link/joint_states/PublishJointState"
    assert by.startswith(f"  published by {node} (isaacsim.ros2.bridge.ROS2PublishJointState, shipped/graphs/dd100/")
    assert any(line.startswith("  velocity[0]: recorded 0.") for line in fields)
    assert before == "  before that, 32 messages in 7 ticks are identical"


def test_another_seed_is_found_at_the_first_scan(graphrun: Graphrun, tmp_path: Path) -> None:
    put(tmp_path / "hall" / "noisy_robot.yaml", NOISY_ROBOT)
    scene = put(tmp_path / "hall" / "scene.yaml", NOISY_SCENE)
    record(tmp_path / "out.mcap", 5, scene, options=Options(seed=7))
    assert graphrun("replay", str(tmp_path / "out.mcap")).code == 0
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--seed", "8", code=1)
    assert result.lines[0] == "different in tick 1, t = 0.016667 s: /dd100_0000/sim_lidar/scan"
    assert "ranges[0]: recorded " in result.out
    assert "(and 540 more of 541 elements)" in result.out
    graphrun("replay", str(tmp_path / "out.mcap"), "--seed", "8", "--ignore", "*/scan", code=0, err="")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--ignore", "*/scan", "--ignore", "/scna")
    assert (result.code, result.err) == (0, "warning: --ignore /scna: no message was sent on a matching topic\n")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "  - Time.simulationTime -> Clock.timeStamp\n",
            "",
            ["different in tick 1, t = 0.016667 s: /clock", "clock.nanosec: recorded 16666666, replayed 0"],
        ),
        (
            "Clock: PublishClock",
            "Clock: {type: PublishClock, inputs: {topicName: time}}",
            ["different in tick 1, t = 0.016667 s: /time", "the recording has no such message"],
        ),
        (
            "  - Tick.tick -> Clock.execIn\n",
            "",
            [
                "different in tick 1, t = 0.016667 s: /clock",
                "the replay sends no such message, and no node publishes it",
            ],
        ),
        (
            "  - Tick.tick -> Clock.execIn\n",
            "  - Gate.execOut -> Clock.execIn\n  - Tick.tick -> Gate.execIn\n",
            ["different in tick 1, t = 0.016667 s: /clock", "the replay sends no such message"],
        ),
    ],
    ids=["wire", "topic", "nothing", "gate"],
)
def test_another_graph_is_found_at_its_first_message(
    graphrun: Graphrun, clock: Path, tmp_path: Path, old: str, new: str, expected: list[str]
) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    text = CLOCK.replace(old, new)
    if "Gate" in new:
        text = text.replace("nodes:\n", "nodes:\n  Gate: {type: IsaacSimulationGate, inputs: {step: 2}}\n")
    clock.write_text(text, encoding="utf-8")
    assert graphrun("replay", str(tmp_path / "out.mcap")).code == 0
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(clock), code=1)
    assert result.lines[0] == expected[0]
    assert f"  {expected[1]}" in result.lines


def test_the_ports_of_the_node_are_shown_as_they_are_in_the_replay(
    graphrun: Graphrun, clock: Path, tmp_path: Path
) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    clock.write_text(CLOCK.replace("ReadSimulationTime", FIXED), encoding="utf-8")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(clock), code=1)
    assert "  Time.simulationTime -> Clock.timeStamp = 2.5" in result.lines
    assert "  clock.sec: recorded 0, replayed 2" in result.lines
    assert f"(isaacsim.ros2.bridge.ROS2PublishClock, {clock}:5:3)" in result.out


def test_a_different_order_of_messages_is_reported(graphrun: Graphrun, tmp_path: Path) -> None:
    text = CLOCK + "  - Tick.tick -> Other.execIn\n  - Time.simulationTime -> Other.timeStamp\n"
    one = "  Clock: PublishClock\n"
    other = "  Other: {type: PublishClock, inputs: {topicName: other}}\n"
    path = put(tmp_path / "hall" / "two.yaml", text.replace(one, one + other))
    record(tmp_path / "out.mcap", 3, path)
    lines = text.replace(one, one + other).splitlines(keepends=True)
    wires = lines.index("  - Tick.tick -> Clock.execIn\n")
    path.write_text("".join(lines[:wires] + lines[wires + 2 :] + lines[wires : wires + 2]), encoding="utf-8")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(path), code=1)
    assert result.lines[0].endswith(": /other")
    assert "  the order differs: the recording has a message of /clock at this place" in result.lines


def test_a_topic_with_another_type_is_a_difference(graphrun: Graphrun, tmp_path: Path) -> None:
    path = put(tmp_path / "hall" / "clock.yaml", CLOCK)
    record(tmp_path / "out.mcap", 3, path)
    tampered = rewritten(tmp_path / "out.mcap", types={"rosgraph_msgs/msg/Clock": "builtin_interfaces/msg/Time"})
    result = graphrun("replay", str(tampered), code=1)
    assert "  recorded as builtin_interfaces/msg/Time, replayed as rosgraph_msgs/msg/Clock" in result.lines


def test_errors_of_a_scene_are_printed(graphrun: Graphrun, clock: Path, tmp_path: Path) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    clock.write_text(CLOCK.replace("Clock.execIn", "Clok.execIn"), encoding="utf-8")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(clock), code=1, out="")
    assert f"{clock}:7:18: error G203: no node 'Clok'" in result.err


def test_an_error_in_the_setup_of_a_replayed_node_names_the_recorded_file(
    graphrun: Graphrun, clock: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record(tmp_path / "out.mcap", 3, clock)
    found = default_registry().find("PublishClock")
    assert found is not None
    setup, asked = found.cls.setup, itertools.count()

    def refuse(node: Node, context: Context) -> None:
        if next(asked):  # after the check
            raise RuntimeError("not now")
        setup(node, context)

    monkeypatch.setattr(found.cls, "setup", refuse)
    result = graphrun("replay", str(tmp_path / "out.mcap"), code=1, out="")
    assert result.err.startswith("error: project/hall/clock.yaml:5:3: node Clock (")


def test_a_graph_without_the_scene_that_it_needs_cannot_be_compared(graphrun: Graphrun, drive: Path) -> None:
    result = graphrun("replay", str(drive), "--against", "dd100/cmd_vel", code=2, out="")
    assert (
        result.err
        == "graphrun replay: --against dd100/cmd_vel: the graph uses prims of a scene; give a scene instead\n"
    )


def test_a_missing_subscription_is_a_difference(graphrun: Graphrun, drive: Path) -> None:
    result = graphrun("replay", str(drive), "--against", "dd100_warehouse", "--set", "SubscribeTwist.topicName=other")
    assert result.code == 1
    assert (
        f"warning: messages of {CMD_VEL} (geometry_msgs/msg/Twist) were recorded, but no node reads them\n"
        in result.err
    )
    assert result.lines[0].startswith("different in tick 8,")


def test_different_versions_and_processors_are_reported_first(graphrun: Graphrun, drive: Path, tmp_path: Path) -> None:
    other = rewritten(drive, manifest={"machine": '{"mujoco-core": "1.2.3", "processor": "Z80", "numba": "0"}'})
    result = graphrun("replay", str(other), "--set", "*DiffController.wheelRadius=0.05", code=1)
    assert "recorded with 1.2.3; results may differ in their last bits\n" in result.err
    assert "recorded with Z80; results may differ in their last bits\n" in result.err


def test_rays_are_those_of_the_recording(graphrun: Graphrun, drive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.cli.recorded_run.find_spec", lambda name: None)
    result = graphrun("replay", str(rewritten(drive, manifest={"rays": '"fast"'})), code=2, out="")
    assert "the run cast the rays of lidars with --rays fast, which needs numba\n" in result.err
    assert "give --rays mujoco" in result.err
    assert (
        "rays: mujoco, recorded with "
        in graphrun("replay", str(rewritten(drive, manifest={"machine": '{"rays": "other"}'})), "--rays", "mujoco").err
    )


def test_modules_are_not_imported_because_a_file_says_so(
    graphrun: Graphrun, clock: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    put(tmp_path / "evil_nodes.py", "raise SystemExit('imported')")
    record(tmp_path / "out.mcap", 1, clock, modules=["evil_nodes"])
    result = graphrun("replay", "out.mcap", code=2)
    assert "the run used modules with node types; if you trust these modules, give --import evil_nodes" in result.err
    assert "--import evil_nodes: SystemExit: imported" in graphrun("replay", "out.mcap", "--import", "evil_nodes").err


def test_a_recording_with_the_former_name_of_the_node_library_is_replayed(graphrun: Graphrun, drive: Path) -> None:
    assert graphrun("replay", str(rewritten(drive, manifest={"modules": '["nodes.core"]'}))).code == 0
