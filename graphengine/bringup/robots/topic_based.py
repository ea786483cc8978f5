"""Writes the `<ros2_control>` element with which ros2_control drives a simulated robot over topics.

The hardware component is JointStateTopicSystem of joint_state_topic_hardware_interface (ROS 2 Jazzy and later), formerly
TopicBasedSystem of topic_based_ros2_control. This component publishes commands as sensor_msgs/JointState with the names of all
joints, but with one value per existing command interface. If a joint had no command interface, the arrays would be shorter than
the list of names. Therefore all joints have the same interfaces. Mimic joints are left out, because robot_state_publisher and
MoveIt compute them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from graphengine.descriptions.robot_description import Joint
from graphengine.format.templates import filled

PLUGIN = "joint_state_topic_hardware_interface/JointStateTopicSystem"
STATES, COMMANDS = "topic_based_joint_states", "topic_based_joint_commands"
"""Topics, without a leading slash; `joint_states` is not used, because joint_state_broadcaster publishes this topic."""


def block(name: str, joints: Sequence[Joint], starts: Mapping[str, float]) -> str:
    """Return the `<ros2_control>` element as XML, indented for the body of a `<robot>`.

    The element does not sum up positions of continuous joints, because the simulation does not wrap them. It has no threshold,
    because the last command of a motion could then be lost.

    Args:
        name: name of the ros2_control system.
        joints: joints to command; fixed joints and mimic joints are left out.
        starts: a dict from joints to initial positions, rad or m; other joints start at 0.
    """
    commanded = [joint.name for joint in joints if joint.moves and joint.mimic is None]
    template = Path(__file__).with_name("topic_based_joint.txt")
    each = (filled(template, name=quoteattr(joint), start=repr(starts.get(joint, 0.0))) for joint in commanded)
    return filled(
        template.with_name("topic_based.txt"),
        name=quoteattr(name),
        plugin=PLUGIN,
        commands=COMMANDS,
        states=STATES,
        joints="".join(each),
    )
