"""`graphrun replay`: what is the same, and runs that ended with an error."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
import trimesh
from rosbags.rosbag2 import Reader

from graphengine.format.files import shipped
from graphengine.format.spec import RobotUse
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.entity_commands import Delete, Spawn
from graphengine.scene.loaded_scene import Options
from tests.cli.harness import Graphrun
from tests.jobs.harness import twist
from tests.physics.pictures.harness import needs_opengl
from tests.recording.harness import (
    CLOCK,
    CMD_VEL,
    GOODBYE,
    NOISY_ROBOT,
    NOISY_SCENE,
    SYSTEM_CLOCK,
    Run,
    at,
    put,
    record,
    rewritten,
)

MEMORY = ("--transport", "memory")
SEEING_ROBOT = """robot: seeing
extends: robots/dd100.yaml
graphs:
  camera: {use: graphs/camera.yaml, parameters: {width: 64, height: 40}}
"""
PARTS = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="body" params="name">
    <link name="${name}">
      <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
      <visual><geometry><mesh filename="package://my_robot/meshes/box.stl"/></geometry></visual>
      <collision><geometry><mesh filename="package://my_robot/meshes/box.stl"/></geometry></collision>
    </link>
  </xacro:macro>
</robot>
"""
ROBOT = """<robot name="own" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="width" default="0.1"/>
  <xacro:include filename="parts.xacro"/>
  <xacro:body name="base_link"/>
  <xacro:body name="arm"/>
  <joint name="turn" type="revolute">
    <parent link="base_link"/><child link="arm"/><origin xyz="0 0 $(arg width)"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>
"""
OWN_MESSAGE = """graph: own
nodes:
  Tick: OnPlaybackTick
  Send:
    type: ROS2Publisher
    inputs: {topicName: reading, messagePackage: my_msgs, messageName: Reading}
connections:
  - Tick.tick -> Send.execIn
"""


def test_a_drive_is_the_same_byte_by_byte(graphrun: Graphrun, drive: Path) -> None:
    graphrun("replay", str(drive), code=0, err="", out="identical: 1302 messages in 300 ticks, 5.000 s\n")


def test_a_replay_without_messages_warns(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    graphrun("run", "demo/round", "--for", "100ms", *MEMORY, "--record", str(path), code=0)
    result = graphrun("replay", str(path), code=0)
    assert result.out == "identical: 0 messages in 6 ticks, 0.100 s\n"
    assert "warning: no message was compared, as the run publishes nothing" in result.err


def test_the_replay_of_a_recorded_run_is_the_same(graphrun: Graphrun, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    ran = graphrun("run", "dd100_flat", "--for", "1s", "--record", str(path), *MEMORY, code=0, out="")
    assert f"recording to {path}\n" in ran.err
    sent = ran.err.split()[-2]
    assert graphrun("replay", str(path)).out == f"identical: {sent} messages in 60 ticks, 1.000 s\n"


@pytest.mark.parametrize(
    "options",
    [
        ("dd100_flat", "--rate", "3"),
        ("dd100_flat", "--seed", "7", "--robot-state", "--rays", "mujoco", "--set", "PublishClock.topicName=time"),
        ("dd100/joint_states", "--scene", "dd100_flat", "--robot-state", "--keep-going"),
    ],
    ids=["paced", "options", "graph"],
)
def test_a_replay_uses_the_options_of_the_run(graphrun: Graphrun, tmp_path: Path, options: tuple[str, ...]) -> None:
    path = tmp_path / "out.mcap"
    assert graphrun("run", *options, "--for", "300ms", "--record", str(path), *MEMORY).code == 0
    result = graphrun("replay", str(path), code=0, err="")
    assert "in 18 ticks" in result.out


def test_a_replay_needs_no_files_of_the_recorded_run(graphrun: Graphrun, tmp_path: Path) -> None:
    urdf = (shipped() / "scenes/robots/dd100/dd100.urdf").read_text(encoding="utf-8")
    head, body = urdf.split(">", 2)[0] + ">", urdf.split(">", 1)[1]
    hall, shared = tmp_path / "alice" / "hall", tmp_path / "alice" / "shared"
    (hall.parent).mkdir()
    put(hall / "scene.yaml", NOISY_SCENE.replace("noisy_robot.yaml", "../shared/robot.yaml"))
    put(shared / "robot.yaml", NOISY_ROBOT + "urdf: own.urdf\n")
    put(shared / "own.urdf", head + body)
    path = tmp_path / "out.mcap"
    record(path, 40, hall / "scene.yaml", commands={3: [(0.5, 0.1)]}, options=Options(allowed=[shared], seed=3))
    shutil.rmtree(hall.parent)
    graphrun("replay", str(path), code=0, err="")


def test_values_of_the_wall_clock_are_replayed(graphrun: Graphrun, clock: Path, tmp_path: Path) -> None:
    clock.write_text(SYSTEM_CLOCK, encoding="utf-8")
    record(tmp_path / "out.mcap", 5, clock)
    assert graphrun("replay", str(tmp_path / "out.mcap")).out.startswith("identical: 5 messages in 5 ticks")


def test_messages_between_nodes_of_the_run_are_delivered_once(graphrun: Graphrun, tmp_path: Path) -> None:

    path = put(
        tmp_path / "hall" / "echo.yaml",
        """graph: echo
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Clock: PublishClock
  Heard: ROS2SubscribeClock
  Again: {type: PublishClock, inputs: {topicName: again}}
connections:
  - Tick.tick -> Clock.execIn
  - Time.simulationTime -> Clock.timeStamp
  - Tick.tick -> Heard.execIn
  - Heard.execOut -> Again.execIn
  - Heard.timeStamp -> Again.timeStamp
""",
    )
    run = record(tmp_path / "out.mcap", 10, path)
    assert sum(topic == "/again" for topic, _, _ in run.heard) == 9
    assert graphrun("replay", str(tmp_path / "out.mcap")).out.startswith("identical: 19 messages in 10 ticks")


@pytest.mark.parametrize("at", [None, "/World/late"])
def test_commands_between_ticks_are_replayed(graphrun: Graphrun, tmp_path: Path, at: str | None) -> None:
    use = RobotUse(use="robots/dd100.yaml", at=at, position=(0.0, 4.0, 0.025), namespace="late")

    def command(tick: int, run: Run) -> None:
        if tick == 10:
            Spawn(name="late", use=use).apply(run.session)
        if tick == 20:
            Delete(name="late").apply(run.session)
        if tick == 25:
            run.session.stop()

    run = record(tmp_path / "out.mcap", 30, "dd100_flat", commands={22: [(0.5, 0.0)]}, before=command)
    assert sum(topic == "/late/odom" for topic, _, _ in run.heard) == 10
    result = graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")
    assert result.out.endswith(" in 30 ticks, 0.500 s\n")


def test_messages_sent_at_a_stop_and_at_the_end_are_the_same(graphrun: Graphrun, tmp_path: Path) -> None:
    path = put(tmp_path / "hall" / "graph.yaml", GOODBYE)
    run = record(tmp_path / "out.mcap", 10, path, before=at(6, lambda run: run.session.stop()))
    assert [topic for topic, _, _ in run.heard if topic != "/clock"] == ["/stopped", "/stopped", "/closed"]
    with Reader(tmp_path / "out.mcap") as reader:
        said = [(connection.topic, stamp) for connection, stamp, _ in reader.messages()]
    assert [topic for topic, _ in said if topic in ("/stopped", "/closed")] == ["/stopped", "/stopped", "/closed"]
    graphrun("replay", str(tmp_path / "out.mcap"), code=0, out="identical: 14 messages in 10 ticks, 0.167 s\n")


def test_queued_commands_are_repeated_to_the_last_bit(graphrun: Graphrun, tmp_path: Path) -> None:
    hall, yard = tmp_path / "here" / "hall", tmp_path / "here" / "yard"
    scene = put(hall / "scene.yaml", NOISY_SCENE)
    put(hall / "noisy_robot.yaml", NOISY_ROBOT)
    own = put(yard / "own.yaml", f"robot: own\nextends: base.yaml\n{NOISY_ROBOT.partition('dd100.yaml')[2]}")
    put(yard / "base.yaml", "robot: base\nextends: robots/dd100.yaml\n")
    late = {"position": [-1.0, 6.0, 0.025], "orientation": {"rpy_deg": [0.0, 0.0, 33.3]}, "namespace": "late"}
    turned = {"quaternion_xyzw": [0.001, 0.002, 0.30070584, 0.95371696]}
    asked: dict[int, list[tuple[str, dict[str, Any]]]] = {
        3: [("push", {"entity": "dd100", "impulse": [4.0, 2.0, 0.0]})],
        7: [("spawn", {"name": "late", "use": {"use": str(own), **late}}), ("rate", {"factor": 0.5})],
        8: [("spawn", {"name": "later", "use": {"use": "noisy_robot.yaml", "namespace": "later"}})],
        11: [("push", {"entity": "late", "force": [0.0, 90.0, 5.0], "duration": 0.777, "at": [-1.0, 6.1, 0.3]})],
        12: [("command", {"robot": "dd100", "velocities": {"front_left_wheel_joint": 0.1}})],
        13: [("move", {"entity": "dd100", "position": [-3.1, 5.7], "orientation": turned, "linear": [0.3, 0.1, 0.0]})],
        14: [("delete", {"name": "nobody"}), ("delete", {"name": "later"})],
        29: [("reset", {"scope": "state"}), ("push", {"entity": "dd100", "force": [0.0, 60.0, 0.0], "duration": 9.0})],
        37: [("reset", {"scope": "time"}), ("pause", {}), ("play", {})],
        41: [("move", {"entity": "box_01", "position": [-3.0, 6.6, 0.6]})],
        59: [("reset", {})],
        67: [("spawn", {"name": "late", "use": {"use": str(own), **late}})],
        71: [("stop", {}), ("move", {"entity": "late", "angular": [0.0, 0.0, 1.0]})],
    }
    queue, refused = CommandQueue(lambda: 0.0), list[Any]()  # all that is asked for in a tick is done in it

    def ask(tick: int, run: Run) -> None:
        answers = [queue.submit(name, arguments) for name, arguments in asked.get(tick, [])]
        queue.serve(run.session)
        refused.extend(error for answer in answers if (error := answer.exception(0)))

    drive = {tick: [(0.5, 0.2 * (-1) ** tick)] for tick in range(1, 80, 5)}
    options = Options(allowed=[yard])
    run = record(tmp_path / "out.mcap", 80, scene, commands=drive, before=ask, options=options)
    assert [str(error).split("\n")[0] for error in refused] == ["no robot 'nobody'"]
    assert sum(topic == "/late/odom" for topic, _, _ in run.heard) == (59 - 7) + (81 - 67)
    shutil.rmtree(tmp_path / "here")
    result = graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")
    assert f"{len(run.heard)} messages in 80 ticks" in result.out


@needs_opengl
def test_a_replay_renders_the_same_images_on_the_same_opengl_driver(graphrun: Graphrun, tmp_path: Path) -> None:
    put(tmp_path / "hall" / "robot.yaml", SEEING_ROBOT)
    scene = put(tmp_path / "hall" / "scene.yaml", NOISY_SCENE.replace("noisy_robot.yaml", "robot.yaml"))
    run = record(tmp_path / "out.mcap", 12, scene, commands={2: [(0.5, 0.5)]})
    assert sum(kind == "sensor_msgs/msg/Image" for _, kind, _ in run.heard) >= 2
    graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")
    other = rewritten(tmp_path / "out.mcap", manifest={"machine": '{"OpenGL": "a GPU"}'})
    assert "warning: OpenGL: " in graphrun("replay", str(other)).err


def test_a_recording_of_a_xacro_robot_contains_all_its_files(graphrun: Graphrun, tmp_path: Path) -> None:
    package, hall = tmp_path / "ws" / "my_arm", tmp_path / "ws" / "hall"
    put(package / "package.xml", "<package><name>my_robot</name></package>")
    put(package / "urdf" / "parts.xacro", PARTS)
    put(package / "urdf" / "robot.urdf.xacro", ROBOT)
    (package / "meshes").mkdir()
    trimesh.creation.box((0.4, 0.3, 0.2)).export(package / "meshes" / "box.stl")
    put(hall / "robot.yaml", "robot: own\nurdf: ../my_arm/urdf/robot.urdf.xacro\nxacro_arguments: {width: 0.3}\n")
    put(hall / "scene.yaml", "scene: own\nworld: worlds/flat_grid.xml\nrobots:\n  own: {use: robot.yaml}\n")
    options = Options(allowed=[package], robot_state=True)
    run = record(tmp_path / "out.mcap", 5, hall / "scene.yaml", options=options)
    assert any(topic.endswith("/robot_description") for topic, _, _ in run.heard)
    shutil.rmtree(tmp_path / "ws")
    graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")


def test_localization_is_replayed(graphrun: Graphrun, tmp_path: Path) -> None:
    run = record(tmp_path / "out.mcap", 30, "dd100_flat", options=Options(localization="truth"))
    assert sum(topic.endswith("/tf") for topic, _, _ in run.heard) == 60
    graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")


def test_message_types_of_the_user_are_read_from_the_recording(graphrun: Graphrun, tmp_path: Path) -> None:
    definition = put(tmp_path / "ws" / "my_msgs" / "msg" / "Reading.msg", "float64 value 2.5\nstring[] names\n")
    graph = put(tmp_path / "hall" / "own.yaml", OWN_MESSAGE)
    options = Options(message_paths=[tmp_path / "ws"])
    run = record(tmp_path / "out.mcap", 3, graph, options=options)
    assert [kind for _, kind, _ in run.heard] == ["my_msgs/msg/Reading"] * 3
    definition.unlink()
    graphrun("replay", str(tmp_path / "out.mcap"), code=0, err="")
    put(definition, "float64 value 3.5\nstring[] names\n")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(graph), "--msg-path", str(tmp_path / "ws"))
    assert result.code == 1
    assert "  value: recorded 2.5, replayed 3.5" in result.lines


def test_a_replayed_subscription_has_the_recorded_message_type(graphrun: Graphrun, tmp_path: Path) -> None:
    peers: list[Any] = []

    def speak(tick: int, run: Run) -> None:
        if tick == 2:
            peers.append(run.transport.writer(CMD_VEL, "geometry_msgs/msg/TwistStamped", QoS()))
        if tick > 2:
            stamped = messages.TwistStamped(messages.header(0.0, ""), twist(0.5, 0.0))
            peers[0].write(messages.encode(stamped))

    record(tmp_path / "out.mcap", 70, "dd100_flat", before=speak)
    with Reader(tmp_path / "out.mcap") as reader:
        types = {connection.topic: connection.msgtype for connection in reader.connections}
    assert types[CMD_VEL] == "geometry_msgs/msg/TwistStamped"
    assert graphrun("replay", str(tmp_path / "out.mcap")).code == 0


# Runs that ended with an error


RAISING = """  - Tick.tick -> Third.execIn
  - Third.execOut -> Late.execIn
  - Never.simulationTime -> Late.timeStamp
""".join([CLOCK, ""]).replace(
    "nodes:\n",
    """nodes:
  Third: {type: IsaacSimulationGate, inputs: {step: 3}}
  Never: {type: ReadSimulationTime, inputs: {referenceTimeNumerator: 2147483648, referenceTimeDenominator: 1}}
  Late: {type: PublishClock, inputs: {topicName: late}}
""",
)
"""In tick 3 it publishes a time that no message can hold."""
HARMLESS = RAISING.replace("2147483648", "5")


def test_a_run_that_ended_with_an_error_ends_with_the_same_error(
    graphrun: Graphrun, clock: Path, tmp_path: Path
) -> None:
    clock.write_text(RAISING, encoding="utf-8")
    path = tmp_path / "out.mcap"
    ran = graphrun("run", str(clock), "--for", "1s", "--record", str(path), "--bad-values", "stop", *MEMORY, code=1)
    assert "a stamp cannot be 2147483648" in ran.err
    result = graphrun("replay", str(path), code=0, err="")
    assert result.out.startswith("identical: 2 messages in 2 ticks")
    clock.write_text(HARMLESS, encoding="utf-8")
    result = graphrun("replay", str(path), "--against", str(clock), code=1)
    assert result.lines[0] == "different in tick 3, t = 0.050000 s"
    assert "  replayed: the run goes on" in result.lines
    assert any(line.startswith("  recorded: node Late (") for line in result.lines)


def test_an_error_that_the_recorded_run_did_not_have_is_a_difference(
    graphrun: Graphrun, clock: Path, tmp_path: Path
) -> None:
    clock.write_text(HARMLESS, encoding="utf-8")
    record(tmp_path / "out.mcap", 3, clock, bad_values="stop")
    clock.write_text(RAISING, encoding="utf-8")
    result = graphrun("replay", str(tmp_path / "out.mcap"), "--against", str(clock), code=1)
    assert "  recorded: the run goes on" in result.lines
    assert any("replayed: " in line and "a stamp cannot be" in line for line in result.lines)
