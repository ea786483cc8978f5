"""Messages as text: the forms of ros2cli, held against its own code where ROS is there."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.interfaces import Nodetype

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.message_text import Style, TypedValue, to_csv, to_expression, to_plain_text, to_yaml
from graphengine.ros.transports.rcl.rcl_profiles import ros_class
from tests.ros import needs

PACKAGES = ("std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs", "tf2_msgs", "diagnostic_msgs", "rcl_interfaces")
TYPES = [name for name in DEFINITIONS.names() if name.startswith(PACKAGES) and "/msg/" in name]
OF_ROS = [pytest.param(name, marks=pytest.mark.ros(needs.types(name.partition("/")[0]))) for name in TYPES]
STYLES = [Style(), Style(2), Style(128), Style(arrays=False), Style(1, texts=False), Style(3, flow=True)]


def joint_state() -> Any:
    header, numbers = messages.header(1.5, "base"), np.array([0.1, 1e17, np.nan])
    return messages.JointState(header, ["left", "right"], numbers, np.zeros(0), np.array([-np.inf]))


def full(message_type: str, depth: int = 0) -> Any:
    """A message in whose arrays of any length there are three elements, and whose numbers and texts differ."""
    message = DEFINITIONS.initial(message_type)
    fields = DEFINITIONS.fields(message_type)
    for index, (name, kind) in enumerate(fields):
        setattr(message, name, value(kind, index + 7 * depth, depth))
    return message


def value(kind: Any, seed: int, depth: int) -> Any:
    what, detail = kind
    if what == Nodetype.NAME:
        return full(detail, depth + 1)
    if what == Nodetype.BASE:
        number = seed * 0.1 if "float" in detail[0] else seed
        return {"string": f"text {seed}: ü", "bool": seed % 2 == 0}.get(detail[0], number)
    element, count = detail
    values = [value(element, seed + i, depth) for i in range(count or 3)] if what == Nodetype.ARRAY or not count else []
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        return np.array(values, {"byte": "int8", "char": "uint8"}.get(element[1][0], element[1][0]))
    return values


def of_ros(message_type: str) -> Any:
    """The same message as rclpy has it."""
    from rclpy.serialization import deserialize_message

    data = messages.encode(full(message_type))
    return deserialize_message(data, ros_class(message_type, service=False))


def ours(message_type: str) -> TypedValue:
    """The same message as it comes from the wire."""
    return TypedValue.of(messages.decode(messages.encode(full(message_type)), message_type))


@pytest.mark.ros(needs.module("rosidl_runtime_py"))
@pytest.mark.parametrize("message_type", TYPES)
def test_the_yaml_and_csv_texts_of_each_message_type_equal_those_of_ros2cli(message_type: str) -> None:
    runtime = importlib.import_module("rosidl_runtime_py")
    part, theirs = ours(message_type), of_ros(message_type)
    for style in STYLES:
        options = {"truncate_length": style.longest, "no_arr": not style.arrays, "no_str": not style.texts}
        assert to_yaml(part, style) == runtime.message_to_yaml(theirs, **options, flow_style=style.flow)
        assert to_csv(part, style) == runtime.message_to_csv(theirs, **options)


@pytest.mark.parametrize("message_type", OF_ROS)
def test_expressions_and_single_fields_have_the_text_of_ros2cli(message_type: str) -> None:
    theirs = of_ros(message_type)
    assert to_expression(ours(message_type)) == repr(theirs)
    for name, part in ours(message_type).fields():
        if not part.is_message:
            assert to_plain_text(part) == str(getattr(theirs, name))


def test_yaml_has_one_field_on_each_line_in_the_order_of_the_definition() -> None:
    assert to_yaml(TypedValue.of(joint_state())) == (
        "header:\n  stamp:\n    sec: 1\n    nanosec: 500000000\n  frame_id: base\n"
        "name:\n- left\n- right\nposition:\n- 0.1\n- 1.0e+17\n- .nan\nvelocity: []\neffort:\n- -.inf\n"
    )


def test_yaml_can_be_read_back() -> None:
    read = yaml.safe_load(to_yaml(TypedValue.of(full("sensor_msgs/msg/CameraInfo"))))
    assert read["distortion_model"].startswith("text ")
    assert len(read["k"]) == 9


def test_long_values_are_cut_with_a_mark() -> None:
    scan = DEFINITIONS.initial("sensor_msgs/msg/LaserScan")
    scan.header.frame_id, scan.ranges = "laser", np.arange(3, dtype=np.float32)
    shown = to_yaml(TypedValue.of(scan), Style(longest=2))
    assert "frame_id: la...\n" in shown
    assert shown.endswith("ranges:\n- 0.0\n- 1.0\n- '...'\nintensities: []\n")
    assert "..." not in to_yaml(TypedValue.of(scan), Style())


def test_arrays_and_texts_can_be_left_out() -> None:
    shown = to_yaml(TypedValue.of(joint_state()), Style(arrays=False, texts=False))
    assert "frame_id: '<string length: <4>>'\nname: '<sequence type: string, length: 2>'\n" in shown
    assert "position: '<sequence type: double, length: 3>'\n" in shown
    odometry = DEFINITIONS.initial("nav_msgs/msg/Odometry")
    assert "covariance: '<array type: double[36]>'" in to_yaml(TypedValue.of(odometry), Style(arrays=False))


def test_flow_style_puts_lists_in_brackets_and_fields_on_lines() -> None:
    shown = to_yaml(TypedValue.of(joint_state()), Style(flow=True))
    assert "\nname: [left, right]\nposition: [0.1, 1.0e+17, .nan]\nvelocity: []\n" in shown


def test_csv_is_one_line_with_a_column_for_each_value() -> None:
    assert to_csv(TypedValue.of(joint_state())) == "1,500000000,base,left,right,0.1,1e+17,nan,,-inf"


def test_csv_keeps_the_column_of_an_empty_first_value() -> None:
    key_value = DEFINITIONS.initial("diagnostic_msgs/msg/KeyValue")
    assert to_csv(TypedValue.of(key_value)) == ","


def test_bytes_are_shown_as_characters() -> None:
    status = DEFINITIONS.initial("diagnostic_msgs/msg/DiagnosticStatus")
    status.level = -1  # as rosbags has 255
    assert to_yaml(TypedValue.of(status)).startswith("level: ÿ\n")
    begun = "diagnostic_msgs.msg.DiagnosticStatus(level=b'\\xff', name='', "
    assert to_expression(TypedValue.of(status)).startswith(begun)


def test_a_message_without_fields_has_a_text() -> None:
    empty = TypedValue.of(DEFINITIONS.initial("std_msgs/msg/Empty"))
    assert (to_yaml(empty), to_csv(empty), to_expression(empty)) == ("{}\n", "", "std_msgs.msg.Empty()")


def test_a_field_is_found_by_its_path() -> None:
    part = TypedValue.of(joint_state())
    assert part.find("header.stamp.nanosec").value == 500_000_000
    assert part.find("header").is_message
    assert part.find("").value is part.value
    assert to_plain_text(part.find("name")) == "['left', 'right']"
    assert to_plain_text(part.find("effort")) == "array('d', [-inf])"


@pytest.mark.parametrize(
    ("path", "complaint"),
    [
        ("positoin", "no field 'positoin' in 'positoin'\ndid you mean 'position'?"),
        ("header.stamp.x", "no field 'x' in 'header.stamp.x'\nfields: sec, nanosec"),
        ("name.0", "no field '0' in 'name.0'\nfields: none"),
    ],
)
def test_the_error_about_an_unknown_field_lists_the_fields(path: str, complaint: str) -> None:
    with pytest.raises(TransportError) as told:
        TypedValue.of(joint_state()).find(path)
    assert str(told.value) == complaint
