"""Writes the `<ros2_control>` element with which ros2_control drives a simulated robot over topics.

The hardware component is JointStateTopicSystem of joint_state_topic_hardware_interface (ROS 2 Jazzy and later), formerly
TopicBasedSystem of topic_based_ros2_control. It publishes commands as sensor_msgs/JointState with the names of all joints, but
with one value per existing command interface. If a joint had no command interface, the arrays would be shorter than the list of
names. Therefore all joints have the same interfaces, and mimic joints are left out; robot_state_publisher and MoveIt compute
them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from xml.sax.saxutils import quoteattr

from graphengine.descriptions.robot_description import Joint

PLUGIN = "joint_state_topic_hardware_interface/JointStateTopicSystem"
STATES, COMMANDS = "topic_based_joint_states", "topic_based_joint_commands"
"""Topics, without a leading slash; states are not on `joint_states`, because joint_state_broadcaster publishes that topic."""


def block(name: str, joints: Sequence[Joint], starts: Mapping[str, float]) -> str:
    """Return the `<ros2_control>` element as XML, indented for the body of a `<robot>`.

    Args:
        name: name of the ros2_control system.
        joints: joints to command; fixed joints and mimic joints are left out.
        starts: initial positions by joint name, rad or m; other joints start at 0.
    """
    parameters = {
        "joint_commands_topic": f"/{COMMANDS}",
        "joint_states_topic": f"/{STATES}",
        "sum_wrapped_joint_states": "false",  # the simulation does not wrap positions of continuous joints
        "trigger_joint_command_threshold": "-1",  # with a threshold, the last command of a motion can be lost
    }
    lines = [f'  <ros2_control name={quoteattr(name)} type="system">', "    <hardware>"]
    lines.append(f"      <plugin>{PLUGIN}</plugin>")
    lines += (f'      <param name="{key}">{value}</param>' for key, value in parameters.items())
    lines.append("    </hardware>")
    for joint in joints:
        if joint.moves and joint.mimic is None:
            lines += _joint(joint.name, starts.get(joint.name, 0.0))
    return "\n".join([*lines, "  </ros2_control>", ""])


def _joint(name: str, start: float) -> list[str]:
    return [
        f"    <joint name={quoteattr(name)}>",
        '      <command_interface name="position"/>',
        '      <command_interface name="velocity"/>',
        '      <state_interface name="position">',
        f'        <param name="initial_value">{start!r}</param>',
        "      </state_interface>",
        '      <state_interface name="velocity"/>',
        '      <state_interface name="effort"/>',
        "    </joint>",
    ]
