"""The dd100 in its warehouse with a subscriber of each type, and messages that no sane program sends."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.format.files import find_file
from tests.messages.test_messages import random_message

TOPICS = {
    "/dd100_0000/cmd_vel": "geometry_msgs/msg/Twist",
    "/joint_command": "sensor_msgs/msg/JointState",
    "/ackermann_cmd": "ackermann_msgs/msg/AckermannDriveStamped",
    "/other_clock": "rosgraph_msgs/msg/Clock",
    "/places": "tf2_msgs/msg/TFMessage",
    "/number": "std_msgs/msg/Int32",
}
"""One of each type of node that subscribes."""

JOINTS = """graph: joints
nodes:
  Tick: OnPlaybackTick
  Commands: {type: ROS2SubscribeJointState, inputs: {topicName: /joint_command}}
  Controller: {type: IsaacArticulationController, inputs: {robotPath: /dd100}}
connections:
  - Tick.tick -> Commands.execIn
  - Commands.execOut -> Controller.execIn
  - Commands.jointNames -> Controller.jointNames
  - Commands.positionCommand -> Controller.positionCommand
  - Commands.velocityCommand -> Controller.velocityCommand
  - Commands.effortCommand -> Controller.effortCommand
"""
STEERING = """graph: steering
nodes:
  Tick: OnPlaybackTick
  Drive: {type: ROS2SubscribeAckermannDrive, inputs: {topicName: /ackermann_cmd}}
  Wheels: {type: AckermannController, inputs: {wheelBase: 1.6, trackWidth: 1.2, frontWheelRadius: 0.3}}
connections:
  - Tick.tick -> Drive.execIn
  - Drive.execOut -> Wheels.execIn
  - Tick.deltaSeconds -> Wheels.dt
  - Drive.speed -> Wheels.speed
  - Drive.acceleration -> Wheels.acceleration
  - Drive.steeringAngle -> Wheels.steeringAngle
  - Drive.steeringAngleVelocity -> Wheels.steeringAngleVelocity
"""
ARRIVALS = """graph: arrivals
nodes:
  Tick: OnPlaybackTick
  Clock: {type: ROS2SubscribeClock, inputs: {topicName: /other_clock}}
  Again: {type: PublishClock, inputs: {topicName: /clock_again}}
  Places: {type: ROS2SubscribeTransformTree, inputs: {topicName: /places, frameNamesMap: [/World, world, /other, robot]}}
  Number:
    type: ROS2Subscriber
    inputs: {topicName: /number, messagePackage: std_msgs, messageName: Int32}
  Whole: ToDouble
  Ratio: {type: Divide, inputs: {a: 12.0}}
  Say:
    type: ROS2Publisher
    inputs: {topicName: /ratio, messagePackage: std_msgs, messageName: Float64}
connections:
  - Tick.tick -> Clock.execIn
  - Clock.execOut -> Again.execIn
  - Clock.timeStamp -> Again.timeStamp
  - Tick.tick -> Places.execIn
  - Tick.tick -> Number.execIn
  - Number.data -> Whole.value
  - Whole.converted -> Ratio.b
  - Number.execOut -> Say.execIn
  - Ratio.result -> Say.data
"""
ODD = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1e308, -1e308, 1e9, -1e9, 1e5, -3000.0, 300.0, 1e-300)
ODD_SINGLE = tuple(
    float(np.float32(min(max(number, -3e38), 3e38))) if math.isfinite(number) else number for number in ODD
)
NAMES = ("front_left_wheel_joint", "front_right_wheel_joint", "no_such_joint", "", "\x1b[31m")


def write_scene(folder: Path) -> Path:
    """The warehouse with a graph for each of the topics, and a second robot that transforms move."""
    for name, text in (("joints", JOINTS), ("steering", STEERING), ("arrivals", ARRIVALS)):
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    uses = "".join(f"  {name}: {{use: {name}.yaml}}\n" for name in ("joints", "steering", "arrivals"))
    scene = folder / "bad.yaml"
    other = "  other: {use: robots/dd100.yaml, position: [3.0, 6.0, 0.025], namespace: other}\n"
    text = find_file("dd100_warehouse").read_text(encoding="utf-8").replace("graphs:\n", f"{other}graphs:\n")
    scene.write_text(text + uses, encoding="utf-8")
    return scene


def bad_messages(message_type: str, draw: np.random.Generator) -> Iterator[Any]:
    """Messages of a type without end: random ones, of which many have odd numbers and names."""
    numbers = ODD_SINGLE if message_type.startswith("ackermann") else ODD
    while True:
        message = random_message(message_type, draw)
        yield _odd(message, draw, numbers) if draw.random() < 0.7 else message


def _odd(value: Any, draw: np.random.Generator, numbers: Sequence[float]) -> Any:
    if hasattr(value, "__msgtype__"):
        for name in vars(value):
            if name != "__msgtype__":
                setattr(value, name, _odd(getattr(value, name), draw, numbers))
        if value.__msgtype__.endswith("JointState"):
            length = int(draw.integers(0, 4))
            value.name = [str(name) for name in draw.permutation(NAMES[: draw.choice([2, len(NAMES)])])[:length]]
            length = len(value.name)
            for name in ("position", "velocity", "effort"):
                setattr(value, name, draw.choice(ODD, draw.choice([0, length, 7])))
        if value.__msgtype__.endswith("TransformStamped"):
            value.header.frame_id, value.child_frame_id = "world", "robot"
    elif isinstance(value, float):
        return float(draw.choice(numbers))
    elif isinstance(value, int) and not isinstance(value, bool) and draw.random() < 0.5:
        return 0
    elif isinstance(value, list):
        return [_odd(item, draw, numbers) for item in value]
    return value
