"""Mistakes that a run does not report are warnings of `check`; the files of the package have none of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine import load
from graphengine.format.files import shipped
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests.nodes.harness import write
from tests.physics.harness import FLOOR

SILENT = {"W213", "W214", "W215", "W216"}
FILES = [
    path
    for folder in ("graphs", "scenes", "examples")
    for path in sorted((shipped() / folder).rglob("*.yaml"))
    if any(line.startswith(("graph:", "scene:")) for line in path.read_text(encoding="utf-8").splitlines())
]
TICK = "Tick: OnPlaybackTick, Time: IsaacReadSimulationTime"


def codes(tmp_path: Path, nodes: str, wires: str, more: str = "") -> list[str]:
    graph = f"graph: g\n{more}nodes: {{{TICK}, {nodes}}}\nconnections: [{wires}]\n"
    write(tmp_path, {"graph.yaml": graph})
    found = build.load(tmp_path / "graph.yaml").findings.items
    return [finding.code for finding in found if finding.code in SILENT]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(shipped())))
def test_the_shipped_graphs_and_scenes_give_none_of_these_warnings(path: Path) -> None:
    assert [one.render() for one in build.load(path, Options()).findings.items if one.code in SILENT] == []


@pytest.mark.parametrize(
    ("node", "wires", "told"),
    [
        ("P: ROS2PublishClock", "", True),
        ("P: {type: ROS2PublishClock, inputs: {timeStamp: 0.0}}", "", False),
        ("P: ROS2PublishClock", "Time.simulationTime -> P.timeStamp", False),
        ("P: ROS2PublishClock", "Time.missing -> P.timeStamp", False),
        ("P: {type: ROS2PublishJointState, inputs: {jointNames: [a]}}", "Time.simulationTime -> P.sensorTime", False),
        ("P: {type: ROS2PublishRawTransformTree, inputs: {staticPublisher: true}}", "", False),
        ("P: {type: ROS2Publisher, inputs: {messagePackage: std_msgs, messageName: Header}}", "", False),
        ("P: {type: ROS2Publisher, inputs: {messagePackage: sensor_msgs, messageName: Joy}}", "", True),
        ("P: {type: ROS2SubscribeClock}", "", False),
    ],
)
def test_a_publisher_without_a_wired_time_gives_a_warning_unless_its_stamp_is_set(
    tmp_path: Path, node: str, wires: str, told: bool
) -> None:
    found = codes(tmp_path, node, ", ".join(filter(None, ["Tick.tick -> P.execIn", wires])))
    assert [code for code in found if code == "W213"] == ["W213"] * told


def test_the_time_input_of_a_subgraph_can_be_wired_by_its_user(tmp_path: Path) -> None:
    ports = "inputs: {run: Publish.execIn, time: Publish.timeStamp}\n"
    write(tmp_path, {"inner.yaml": f"graph: inner\n{ports}nodes: {{Publish: ROS2PublishClock}}\nconnections: []\n"})
    assert not build.load(tmp_path / "inner.yaml").findings.items
    for wires, told in (("Time.simulationTime -> In.time", []), ("", ["W213"])):
        used = ", ".join(filter(None, ["Tick.tick -> In.run", wires]))
        assert codes(tmp_path, "In: {subgraph: inner.yaml}", used) == told


@pytest.mark.parametrize(
    ("more", "wires", "told"),
    [
        (
            "Source: {type: ConstructArray, inputs: {arraySize: 2, input0: {type: double, value: 1.0}}}",
            "Source.array",
            False,
        ),
        ("Source: {type: ConstructArray, inputs: {input0: {type: double, value: 1.0}}}", "Source.array", True),
        ("Source: DifferentialController", "Source.velocityCommand", False),
        ("Source: AckermannController", "Source.wheelRotationVelocity", True),
        ("Source: AckermannController", "Source.wheelAngles", False),
        ("Source: ROS2SubscribeJointState", "Source.velocityCommand", False),
    ],
)
def test_a_command_without_one_number_per_joint_gives_a_warning(
    tmp_path: Path, more: str, wires: str, told: bool
) -> None:
    art = "Art: {type: IsaacArticulationController, inputs: {targetPrim: /bot, jointNames: [a, b]}}"
    found = codes(tmp_path, f"{more}, {art}", f"Tick.tick -> Art.execIn, {wires} -> Art.velocityCommand")
    assert found == ["W215"] * told


URDF = """<robot name="bot"><link name="base_link"/><link name="arm"><inertial><mass value="1"/>
<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="continuous"><parent link="base_link"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("drive", "inputs", "told"),
    [
        ("damping: 5, stiffness: 50", "velocityCommand: [1.0]", True),
        ("damping: 5", "velocityCommand: [1.0]", False),
        ("damping: 5, stiffness: 50", "positionCommand: [1.0]", False),
        ("damping: 5, stiffness: 50", "positionCommand: [1.0], velocityCommand: [1.0]", False),
        ("damping: 5, stiffness: 50", "effortCommand: [1.0]", False),
    ],
)
def test_a_velocity_command_against_stiffness_gives_a_warning_with_the_position_where_the_joint_stops(
    tmp_path: Path, drive: str, inputs: str, told: bool
) -> None:
    graph = (
        "graph: g\nnodes: {Tick: OnPlaybackTick, Art: {type: IsaacArticulationController, inputs: {targetPrim: /bot, "
    )
    graph += f"{inputs}}}}}}}\nconnections: [Tick.tick -> Art.execIn]\n"
    robot = f"robot: bot\nurdf: bot.urdf\njoints: {{turn: {{drive: {{{drive}}}}}}}\n"
    scene = "scene: s\nworld: world.xml\nrobots: {bot: {use: bot.yaml}}\ngraphs: {g: {use: graph.yaml, at: /World/g}}\n"
    files = {"world.xml": FLOOR, "bot.urdf": URDF, "bot.yaml": robot, "scene.yaml": scene, "graph.yaml": graph}
    write(tmp_path, files)
    found = [one for one in build.load(tmp_path / "scene.yaml").findings.items if one.code == "W214"]
    assert len(found) == told
    if told:
        assert "turn stops 0.1 from" in found[0].help[1]
        with load(tmp_path / "scene.yaml").session() as sim:
            sim.run(3.0)
            assert sim.robots["bot"].joints["turn"].position == pytest.approx(5 / 50, abs=1e-3)
