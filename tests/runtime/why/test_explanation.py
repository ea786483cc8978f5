"""Three robots that stand still: the explanation names the hidden reason of each, from commands to wheels."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from tests.physics.bases import SKID
from tests.physics.harness import Project

TWIST = {"linear": {"x": 0.5}}
TYPE = "geometry_msgs/msg/Twist"
SECONDS = 1.5

DINGO_DRIVE = """graph: drive
at: /bot/drive
nodes:
  Tick: OnPlaybackTick
  Twist: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel}}
  Linear: BreakVector3
  Angular: BreakVector3
  Enabled: {type: omni.graph.action.Branch, inputs: {condition: true}}
  Controller:
    type: isaacsim.robot.wheeled_robots.DifferentialController
    inputs: {wheelRadius: 0.049, wheelDistance: 0.4523}
  Wheels:
    type: ArticulationController
    inputs: {targetPrim: /bot, jointNames: [front_left_wheel_joint, front_right_wheel_joint]}
connections:
  - Tick.tick -> Twist.execIn
  - Tick.tick -> Enabled.execIn
  - Enabled.execTrue -> Controller.execIn
  - Enabled.execTrue -> Wheels.execIn
  - Twist.linearVelocity -> Linear.tuple
  - Linear.x -> Controller.linearVelocity
  - Twist.angularVelocity -> Angular.tuple
  - Angular.z -> Controller.angularVelocity
  - Controller.velocityCommand -> Wheels.velocityCommand
"""
SKID_DRIVE = """graph: drive
at: /bot/drive
nodes:
  Tick: OnPlaybackTick
  Twist: {type: ROS2SubscribeTwist, inputs: {topicName: cmd_vel}}
  Linear: BreakVector3
  Enabled: {type: omni.graph.action.Branch, inputs: {condition: true}}
  Controller:
    type: isaacsim.robot.wheeled_robots.DifferentialController
    inputs: {wheelRadius: 0.1651, wheelDistance: 0.5708}
  Front: {type: ArticulationController, inputs: {targetPrim: /bot, jointNames: [front_left_joint, front_right_joint]}}
  Rear: {type: ArticulationController, inputs: {targetPrim: /bot, jointNames: [rear_left_joint, rear_right_joint]}}
connections:
  - Tick.tick -> Twist.execIn
  - Tick.tick -> Enabled.execIn
  - Enabled.execTrue -> Controller.execIn
  - Enabled.execTrue -> Front.execIn
  - Enabled.execTrue -> Rear.execIn
  - Twist.linearVelocity -> Linear.tuple
  - Linear.x -> Controller.linearVelocity
  - Controller.velocityCommand -> Front.velocityCommand
  - Controller.velocityCommand -> Rear.velocityCommand
"""
ARM = """<robot name="bot">
<link name="base_link"><inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="upper"><inertial><origin xyz="0.3 0 0"/><mass value="1"/>
<inertia ixx="0.03" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.3 0 0"/><geometry><box size="0.5 0.05 0.05"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper"/><axis xyz="{axis}"/>
<limit lower="-1" upper="1" effort="{effort}" velocity="2"/><dynamics damping="0.5"/></joint></robot>"""
ARM_DRIVE = """graph: drive
at: /bot/drive
nodes:
  Tick: OnPlaybackTick
  Command: {type: ROS2SubscribeJointState, inputs: {topicName: joint_command}}
  Joints: {type: ArticulationController, inputs: {targetPrim: /bot}}
connections:
  - Tick.tick -> Command.execIn
  - Command.execOut -> Joints.execIn
  - Command.jointNames -> Joints.jointNames
  - Command.positionCommand -> Joints.positionCommand
"""
PUBLISH_BEST_EFFORT = """graph: teleop
at: /World/teleop
nodes:
  Tick: OnPlaybackTick
  Sender:
    type: isaacsim.ros2.bridge.ROS2Publisher
    inputs:
      messagePackage: geometry_msgs
      messageName: Twist
      topicName: cmd_vel
      qosProfile: '%s'
connections: [Tick.tick -> Sender.execIn]
"""
BEST_EFFORT = json.dumps({"history": "keepLast", "depth": 1, "reliability": "bestEffort", "durability": "volatile"})


def dingo(drive: str = "damping: 50.0", keys: str = "") -> dict[str, str]:
    """The Dingo-D, with another drive."""
    joints = "".join(f"  front_{side}_wheel_joint: {{drive: {{{drive}}}}}\n" for side in ("left", "right"))
    less = "namespaces: {base_link: null}\ngraphs: {joint_states: null, scan: null, cmd_vel: null}"
    return {
        "bot.yaml": f"robot: bot\nextends: robots/dd100.yaml\n{less}\njoints:\n{joints}{keys}",
        "drive.yaml": DINGO_DRIVE,
    }


def skid(drive: str = "damping: 50.0", keys: str = "") -> dict[str, str]:
    """A skid-steered base with four wheels, and another drive."""
    files = SKID.files(keys)
    return {name: text.replace("damping: 50.0", drive) for name, text in files.items()} | {"drive.yaml": SKID_DRIVE}


def arm(drive: str = "stiffness: 500, damping: 50", effort: float = 50.0, axis: str = "0 0 1") -> dict[str, str]:
    """An arm with one joint, whose link weighs 1 kg at 0.3 m from the axis."""
    text = f"robot: bot\nurdf: bot.urdf\nfixed_base: true\njoints:\n  shoulder: {{drive: {{{drive}}}}}\n"
    return {"bot.urdf": ARM.format(effort=effort, axis=axis), "bot.yaml": text, "drive.yaml": ARM_DRIVE}


WALL = '<body name="wall" pos="1 0 0.5"><geom type="box" size="0.1 3 0.5" friction="0 0 0" priority="9"/></body>'
ROBOTS = {"dingo": (dingo, 0.02), "skid": (skid, 0.17)}
"""For each wheeled robot: the function that returns its files, and the height of its base link above the floor, m."""


@contextmanager
def session(
    folder: Path, files: dict[str, str], *, height: float, things: str = "", graphs: str = ""
) -> Iterator[ge.Session]:
    """A session of one robot named `bot` in a world with other bodies and graphs."""
    project = Project(folder).world(things)
    for name, text in files.items():
        project.write(name, text)
    scene = f"scene: test\nworld: world.xml\nrobots: {{bot: {{use: bot.yaml, position: [0, 0, {height}]}}}}\n"
    project.write("scene.yaml", f"{scene}graphs:\n  drive: {{use: drive.yaml}}\n{graphs}")
    with ge.load(folder / "scene.yaml").session() as sim:
        yield sim


def drive(sim: ge.Session) -> str:
    """Command 0.5 m/s ten times a second, and explain what comes of it."""
    sim.publish("/cmd_vel", TWIST, every=0.1, type=TYPE)
    sim.run(SECONDS)
    return sim.why("bot").sentence


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> Any:
    return ROBOTS[request.param]


def test_a_robot_that_follows_its_commands_moves(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height) as sim:
        assert drive(sim).startswith("bot moves: its base at 0.")


def test_the_reason_is_a_command_topic_without_publisher(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height) as sim:
        sim.run(SECONDS)
        assert sim.why("bot").sentence == "nobody publishes on /cmd_vel, from which drive/Twist takes its commands"


def test_the_reason_is_a_publisher_with_incompatible_qos(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    sender = {"teleop.yaml": PUBLISH_BEST_EFFORT % BEST_EFFORT}
    with session(tmp_path, files() | sender, height=height, graphs="  teleop: {use: teleop.yaml}\n") as sim:
        sim.run(SECONDS)
        sentence = sim.why("bot").sentence
    assert sentence.startswith(
        "/cmd_vel: /bot/drive/Twist asks for reliable, /World/teleop/Sender offers bestEffort"
    ), sentence


def test_the_reason_is_wheels_without_drives(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files("stiffness: 100.0, damping: 0.0"), height=height) as sim:
        sentence = drive(sim)
    assert sentence.startswith("the joints of bot have no drive with damping, so velocity commands have no effect; ")


def test_the_reason_is_the_stiffness_of_the_drives(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files("stiffness: 5000, damping: 50"), height=height) as sim:
        assert drive(sim).startswith("the drives of bot hold their positions: ")


def test_the_reason_is_a_speed_limit_of_the_controller(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height) as sim:
        sim.set("Controller.maxLinearSpeed", 0.001)
        limit = "drive/Controller.maxLinearSpeed = 0.001 m/s limits the command to almost nothing"
        assert drive(sim) == f"{limit}: drive/Controller.linearVelocity = 0.5 m/s"


def test_the_reason_is_a_speed_limit_of_the_drives(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files("damping: 50.0, max_velocity: 0.001"), height=height) as sim:
        assert drive(sim).startswith("a limit of bot clamps its commands: velocity of /bot/")


def test_the_reason_is_a_wall(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height, things=WALL) as sim:
        sim.publish("/cmd_vel", TWIST, every=0.1, type=TYPE)
        sim.run(4.0)
        assert re.match(r"bot is stuck: it (pushes against wall with \d+ N|bounces off wall)", sim.why("bot").sentence)


def test_the_reason_is_wheels_in_the_air(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(keys="fixed_base: true\n"), height=height + 0.5) as sim:
        assert drive(sim).startswith("the wheels of bot turn in the air: none of them touches anything; ")


def test_the_reason_is_a_branch_that_pauses_the_controller(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height) as sim:
        sim.set("Enabled.condition", False)
        sentence = drive(sim)
    assert sentence.startswith("drive/Controller has not run since drive/Twist.linearVelocity = (0.5, 0, 0) m/s")
    assert sentence.endswith(": Enabled.execTrue does not fire")


def test_the_reason_is_a_program_that_has_paused(robot: Any, tmp_path: Path) -> None:
    files, height = robot
    with session(tmp_path, files(), height=height) as sim:
        publication = sim.publish("/cmd_vel", TWIST, every=0.1, type=TYPE)
        sim.run(1.0)
        publication.close()
        sim.publish("/cmd_vel", {}, type=TYPE)
        sim.run(3.0)
        assert sim.why("bot").sentence == "this program has sent nothing on /cmd_vel for 3.0 s"


POST = '<body name="post" pos="0.35 0.2 1"><geom type="box" size="0.05 0.05 0.3"/></body>'


def reach(sim: ge.Session, angle: float) -> str:
    """Command an angle of the arm's joint, rad, and explain what comes of it."""
    sim.publish("/joint_command", {"name": ["shoulder"], "position": [angle]}, type="sensor_msgs/msg/JointState")
    sim.run(SECONDS)
    return sim.why("bot").sentence


def test_an_arm_that_has_reached_its_target_stands_where_its_commands_put_it(tmp_path: Path) -> None:
    with session(tmp_path, arm(), height=1.0) as sim:
        assert reach(sim, 0.5) == "bot stands where its commands put it"


def test_the_reason_of_an_arm_is_a_command_topic_without_publisher(tmp_path: Path) -> None:
    with session(tmp_path, arm(), height=1.0) as sim:
        sim.run(SECONDS)
        assert (
            sim.why("bot").sentence == "nobody publishes on /joint_command, from which drive/Command takes its commands"
        )


def test_the_reason_of_an_arm_is_a_drive_without_stiffness(tmp_path: Path) -> None:
    with session(tmp_path, arm("damping: 50"), height=1.0) as sim:
        assert reach(sim, 0.5).startswith(
            "the joints of bot have no drive with stiffness, so position commands have no effect"
        )


def test_the_reason_of_an_arm_is_a_command_for_a_joint_that_it_has_not(tmp_path: Path) -> None:
    with session(tmp_path, arm(), height=1.0) as sim:
        command = {"name": ["sholder"], "position": [0.5]}
        sim.publish("/joint_command", command, type="sensor_msgs/msg/JointState", every=0.1)
        sim.run(SECONDS)
        assert sim.why("bot").sentence.startswith("drive/Joints drops its commands: /bot has no joint 'sholder'")


def test_the_reason_of_an_arm_is_the_end_of_its_range(tmp_path: Path) -> None:
    with session(tmp_path, arm(), height=1.0) as sim:
        reach(sim, 1.0)
        assert reach(sim, 2.0).startswith("a limit of bot clamps its commands: position of /bot/")


def test_the_reason_of_an_arm_is_a_post_in_its_way(tmp_path: Path) -> None:
    with session(tmp_path, arm(), height=1.0, things=POST) as sim:
        assert reach(sim, 1.0).startswith("bot is stuck: it pushes against post with ")


def test_the_reason_of_an_arm_is_a_drive_that_cannot_lift_its_link(tmp_path: Path) -> None:
    with session(tmp_path, arm(effort=2.0, axis="0 1 0"), height=2.0) as sim:  # the link weighs 2.9 N m
        sim.run(10.0)
        assert reach(sim, -0.5) == "the drive of shoulder is too weak: it gives its largest effort of 2"


def test_a_publisher_of_a_similar_topic_is_named(tmp_path: Path) -> None:
    with session(tmp_path, dingo(), height=0.02) as sim:
        sim.publish("/robot/cmd_vel", TWIST, every=0.1, type=TYPE)
        sim.run(SECONDS)
        assert sim.why("bot").sentence.endswith("; but there is a publisher of: /robot/cmd_vel")


def test_a_fault_of_the_command_topic_is_named(tmp_path: Path) -> None:
    with session(tmp_path, dingo(), height=0.02) as sim:
        sim.fault(topic="/cmd_vel", silent=True)
        assert drive(sim) == "a fault of /cmd_vel withholds its messages: `mend` ends it"


def test_the_evidence_has_the_topic_the_values_in_the_graph_and_the_joints(tmp_path: Path) -> None:
    with session(tmp_path, dingo(), height=0.02) as sim:
        drive(sim)
        evidence = sim.why("bot").evidence
    assert evidence[:2] == (
        "/cmd_vel: published by this program; messages received: 16, the last one 0.08 s ago",
        "drive/Twist.linearVelocity = (0.5, 0, 0) m/s",
    )
    assert "drive/Controller.velocityCommand = (10.2, 10.2) rad/s" in evidence
    assert any(
        line.startswith("front_left_wheel_joint: at ") and line.endswith("target 10.204 rad/s") for line in evidence
    )


def test_the_explanation_does_not_change_the_run(tmp_path: Path) -> None:
    outputs = []
    for asks in (False, True):
        (tmp_path / str(asks)).mkdir()
        with session(tmp_path / str(asks), skid(), height=0.17) as sim:
            sim.publish("/cmd_vel", TWIST, every=0.1, type=TYPE)
            for _ in range(60):
                sim.step()
                if asks:
                    sim.why("bot")
            outputs.append(sim.mujoco.data.qpos.tobytes())
    assert outputs[0] == outputs[1]


def test_an_unknown_robot_is_an_error_with_a_suggestion(tmp_path: Path) -> None:
    with (
        session(tmp_path, dingo(), height=0.02) as sim,
        pytest.raises(ge.UnknownEntityError, match="did you mean 'bot'"),
    ):
        sim.why("bott")
