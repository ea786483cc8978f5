"""The ros2_control element for hardware over topics, and the topics, as a twin of that hardware uses them.

The twin does what joint_state_topic_hardware_interface.cpp and topic_based_system.cpp of the two packages do: which names they
look up in a message, what they skip, and which arrays they send.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from graphengine.bringup.robots import topic_based
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.physics.loading import load_robot_file
from tests import arm_robot, arm_scene
from tests.arm_scene import DURATION
from tests.nodes.harness import Player, Playing, write

JOINT_STATE = "sensor_msgs/msg/JointState"
COMMANDED = [*arm_robot.JOINTS, arm_robot.FINGER]
SCENE = """
    format: 1
    scene: arm
    world: worlds/flat_grid.xml
    physics: {tick_rate: 100, substeps: 4}
    robots: {arm: {use: arm.yaml}}
    graphs:
      states:
        use: graphs/joint_states.yaml
        parameters: {robot: /arm, joint_states: topic_based_joint_states}
      commands:
        use: graphs/joint_commands.yaml
        parameters: {robot: /arm, joint_commands: topic_based_joint_commands}
"""


class Hardware:
    """JointStateTopicSystem in Python; commands are NaN until a controller writes them."""

    def __init__(self, xml: str, playing: Playing) -> None:
        system = ElementTree.fromstring(xml)
        self.parameters = {one.get("name"): one.text for one in system.iter("param") if "_" in str(one.get("name"))}
        self.joints = {
            str(joint.get("name")): [str(one.get("name")) for one in joint.iter("command_interface")]
            for joint in system.iter("joint")
        }
        self.state: dict[str, float] = {}
        self.commands = {f"{name}/{kind}": math.nan for name, kinds in self.joints.items() for kind in kinds}
        self.playing = playing
        sensor_data = QoS(depth=5, reliability="bestEffort")  # rclcpp::SensorDataQoS
        playing.transport.reader(str(self.parameters["joint_states_topic"]), JOINT_STATE, sensor_data, self.read)

    def read(self, data: bytes) -> None:
        """Take the state of each joint that the hardware knows, unless it is not finite."""
        state = messages.decode(data, JOINT_STATE)
        for index, name in enumerate(state.name):
            for kind, array in (("position", state.position), ("velocity", state.velocity), ("effort", state.effort)):
                if name in self.joints and len(array) and math.isfinite(array[index]):
                    self.state[f"{name}/{kind}"] = float(array[index])

    def write(self) -> None:
        """Send one number for each command interface, unless commands are within the threshold of the state."""
        apart = sum(abs(self.state[name] - command) for name, command in self.commands.items())
        if apart <= float(str(self.parameters["trigger_joint_command_threshold"])):
            return
        arrays: dict[str, list[float]] = {"position": [], "velocity": [], "effort": []}
        for name, kinds in self.joints.items():
            for kind in kinds:
                arrays[kind].append(self.commands[f"{name}/{kind}"])
        header = messages.Header(messages.stamp(0.0), "")
        message = messages.JointState(header, list(self.joints), *map(np.array, arrays.values()))
        self.playing.transport.inject(str(self.parameters["joint_commands_topic"]), message)


def element(folder: Path) -> str:
    """The element for the arm."""
    write(folder, arm_scene.files())
    robot = load_robot_file(folder / "arm.yaml", Files.of(folder / "arm.yaml"), Findings())
    assert robot is not None
    return topic_based.block("arm", list(robot.description.joints.values()), robot.starts)


class Connected:
    """The scene and the hardware, whose controllers write `position` and `velocity` of a motion."""

    def __init__(self, play: Player) -> None:
        xml = element(play.folder)
        self.playing = play.scene({**arm_scene.files(), "scene.yaml": SCENE})
        self.hardware = Hardware(xml, self.playing)
        self.playing.tick(2)

    def command(self, time: float) -> None:
        for kind, values in zip(("position", "velocity"), arm_scene.motion(min(time, DURATION)), strict=True):
            for name, value in zip(arm_robot.JOINTS, values, strict=True):
                self.hardware.commands[f"{name}/{kind}"] = float(value)
            self.hardware.commands[f"{arm_robot.FINGER}/{kind}"] = 0.0
        self.hardware.write()

    def error(self, time: float) -> float:
        at = np.array([self.hardware.state[f"{name}/position"] for name in arm_robot.JOINTS])
        return float(np.abs(at - arm_scene.motion(min(time, DURATION))[0]).max())


@pytest.fixture
def connected(play: Player) -> Connected:
    return Connected(play)


def test_the_ros2_control_element_lists_commanded_joints_with_interfaces_and_initial_values(
    tmp_path: Path,
) -> None:
    system = ElementTree.fromstring(element(tmp_path))
    assert (system.get("name"), system.get("type")) == ("arm", "system")
    assert [joint.get("name") for joint in system.iter("joint")] == COMMANDED  # not the follower
    for joint in system.iter("joint"):
        assert [one.get("name") for one in joint.iter("command_interface")] == ["position", "velocity"]
        assert [one.get("name") for one in joint.iter("state_interface")] == ["position", "velocity", "effort"]
    starts = [float(str(one.text)) for one in system.iter("param") if one.get("name") == "initial_value"]
    assert starts == pytest.approx([*arm_scene.motion(0.0)[0], 0.0])


def test_names_are_escaped(tmp_path: Path) -> None:
    system = ElementTree.fromstring(topic_based.block('a"<&', [], {}))
    assert system.get("name") == 'a"<&'


def test_the_hardware_finds_position_velocity_and_effort_of_each_joint(connected: Connected) -> None:
    assert set(connected.hardware.state) == {
        f"{name}/{k}" for name in COMMANDED for k in ("position", "velocity", "effort")
    }
    assert connected.error(0.0) < 1e-3  # rad
    assert abs(connected.hardware.state["shoulder_lift/effort"]) > 1.0  # N m, as the drive carries the arm


def test_before_a_controller_runs_commands_are_nan_and_the_arm_holds(connected: Connected) -> None:
    connected.hardware.write()
    connected.playing.tick(50)
    assert connected.error(0.0) < 1e-3
    assert connected.playing.dropped == {}


@pytest.mark.parametrize("rate", [25, 100, 400])
def test_the_arm_follows_a_controller_of_any_rate(connected: Connected, rate: int) -> None:
    worst = 0.0
    for tick in range(round(DURATION * 100)):
        for update in range(max(rate // 100, 1)):
            if rate >= 100 or tick % (100 // rate) == 0:
                connected.command((tick + update / max(rate // 100, 1)) / 100 + 1 / rate)
        connected.playing.tick()
        worst = max(worst, connected.error(tick / 100))  # physics comes before graphs: commands act in the next tick
    assert worst < (0.005 if rate == 100 else 0.1)
    connected.playing.tick(50)
    assert connected.error(DURATION) < 1e-3


def test_a_mimic_joint_in_the_element_makes_arrays_that_are_dropped_with_a_warning(connected: Connected) -> None:
    connected.hardware.joints[arm_robot.FOLLOWER] = []
    connected.command(DURATION)
    logged: list[str] = []
    connected.playing.session.services.log = lambda _, __, text: logged.append(text)
    connected.playing.tick(50)
    assert connected.error(0.0) < 1e-3
    assert logged == [
        "/topic_based_joint_commands: a JointState of 8 joints with 7, 7, 0 positions, velocities and efforts was dropped"
    ]
