"""Messages from YAML as people write it on a command line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.messages.message_input import full_type, parse
from graphengine.messages.message_text import TypedValue, to_yaml

TWIST = "geometry_msgs/msg/Twist"


def made(text: str, message_type: str) -> Any:
    message = parse(text, message_type).message
    messages.check(message)
    return message


def complaint(text: str, message_type: str) -> str:
    with pytest.raises(CheckError) as told:
        parse(text, message_type)
    return str(told.value)


def test_the_yaml_of_the_ros_tutorial_is_parsed() -> None:
    text = "{'linear': {'x': 1, 'y': 0.0, 'z': 0.0}, 'angular': {'x': 0.0, 'y': 0.0, 'z': 1.0}}"
    twist = made(text, TWIST)
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (1.0, 0.0, 1.0)


def test_omitted_fields_have_the_defaults_of_the_definition() -> None:
    pose = made("{position: {x: 1.0}}", "geometry_msgs/msg/Pose")
    assert (pose.position.x, pose.position.y, pose.orientation.w) == (1.0, 0.0, 1.0)
    assert made("{}", "std_msgs/msg/String").data == ""


def test_arrays_of_numbers_texts_and_messages_are_lists() -> None:
    state = made("{name: [left, right], position: [1, 2.5]}", "sensor_msgs/msg/JointState")
    assert (state.name, state.position.tolist(), state.velocity.tolist()) == (["left", "right"], [1.0, 2.5], [])
    path = made("{poses: [{pose: {position: {x: 1}}}, {}]}", "nav_msgs/msg/Path")
    assert [stamped.pose.position.x for stamped in path.poses] == [1.0, 0.0]


@pytest.mark.parametrize(
    ("message_type", "text", "expected"),
    [
        ("std_msgs/msg/Bool", "true", True),
        ("std_msgs/msg/Bool", "on", True),
        ("std_msgs/msg/Bool", "No", False),
        ("std_msgs/msg/Bool", "1", True),
        ("std_msgs/msg/Bool", "0", False),
        ("std_msgs/msg/Int16", "-7", -7),
        ("std_msgs/msg/Int16", "2.0", 2),
        ("std_msgs/msg/UInt8", "0xff", 255),
        ("std_msgs/msg/Float64", "3", 3.0),
        ("std_msgs/msg/Float64", "1e-3", 0.001),
        ("std_msgs/msg/Float64", "-.inf", -float("inf")),
        ("std_msgs/msg/Float64", "'-inf'", -float("inf")),
        ("std_msgs/msg/String", "on", "on"),
        ("std_msgs/msg/String", "5", "5"),
        ("std_msgs/msg/String", "1e3", "1e3"),
        ("std_msgs/msg/String", "True", "True"),
        ("std_msgs/msg/String", '"a: ü"', "a: ü"),
        ("std_msgs/msg/Byte", "255", -1),  # rosbags takes a byte for signed
        ("std_msgs/msg/Char", "200", 200),
    ],
)
def test_the_type_of_the_field_decides_how_a_value_is_read(message_type: str, text: str, expected: object) -> None:
    data = made(f"{{data: {text}}}", message_type).data
    assert (data, type(data)) == (expected, type(expected))


@pytest.mark.parametrize("text", ["auto", "{stamp: now, frame_id: map}"])
def test_auto_and_now_are_the_time_at_which_the_message_is_sent(text: str) -> None:
    draft = parse(f"header: {text}", "geometry_msgs/msg/TwistStamped")
    for nanoseconds in (1, 5_000_000_007):
        header = draft.stamp(nanoseconds).header
        assert (header.stamp.sec, header.stamp.nanosec) == divmod(nanoseconds, 1_000_000_000)
    assert header.frame_id == ("map" if "map" in text else "")


def test_given_times_stay_unchanged() -> None:
    draft = parse("header: {stamp: {sec: 3}}", "geometry_msgs/msg/TwistStamped")
    assert draft.stamp(5_000_000_007).header.stamp.sec == 3


@pytest.mark.parametrize(
    ("message_type", "text", "expected"),
    [
        (TWIST, "{linar: {x: 1}}", "message:1:2: error G106: geometry_msgs/msg/Twist has no field 'linar'"),
        (TWIST, "{linar: {x: 1}}", "did you mean 'linear'?"),
        (TWIST, "{linear: {x: a}}", "message:1:14: error G108: x must be of type float64; got 'a'"),
        (TWIST, "{linear: 1}", "error G108: geometry_msgs/msg/Vector3 must be a mapping of fields to values; got 1"),
        (TWIST, "{linear: {x: true}}", "x must be of type float64; got true"),
        (TWIST, "[1", "error G102: YAML syntax"),
        (TWIST, "", "the file is empty"),
        (TWIST, "hello", "must be a mapping of fields to values; got 'hello'"),
        ("std_msgs/msg/Header", "now", "must be a mapping of fields to values, or 'auto'; got 'now'"),
        ("std_msgs/msg/Int8", "{data: 1000}", "message:1:8: error G109: data is 1000, not a int8"),
        ("std_msgs/msg/Int8", "{data: 1.5}", "data must be of type int8; got 1.5"),
        ("std_msgs/msg/Bool", "{data: maybe}", "data must be of type bool; got 'maybe'"),
        ("std_msgs/msg/String", "{data: }", "data must be of type string; got nothing"),
        ("std_msgs/msg/Float32", "{data: 1e300}", "data is 1e+300, not a float32"),
        ("std_msgs/msg/UInt8MultiArray", "{data: [1, 300]}", "message:1:12: error G109: data[1] is 300, not a uint8"),
        ("std_msgs/msg/UInt8MultiArray", "{data: 1}", "data must be a list; got 1"),
        ("nav_msgs/msg/Odometry", "{pose: {covariance: [1, 2]}}", "covariance has 2 elements, not 36"),
    ],
)
def test_a_value_that_does_not_fit_is_reported_with_its_position(message_type: str, text: str, expected: str) -> None:
    assert expected in complaint(text, message_type)


def test_an_unknown_type_is_reported_with_the_nearest_names() -> None:
    with pytest.raises(MessageTypeError, match=r"'std_msgs/msg/Strin'\ndid you mean '(std_msgs/msg/)?String'\?"):
        parse("{}", "std_msgs/msg/Strin")


def test_the_short_name_of_a_type_means_a_message() -> None:
    assert full_type("geometry_msgs/Twist") == TWIST
    assert full_type(TWIST) == TWIST


@given(st.lists(st.floats(), max_size=4), st.text(max_size=8), st.booleans(), st.integers(-(2**63), 2**63 - 1))
def test_parsing_the_yaml_of_a_printed_message_gives_the_same_message(
    floats: list[float], text: str, flag: bool, number: int
) -> None:
    message_type = "rcl_interfaces/msg/ParameterValue"
    value = DEFINITIONS.initial(message_type)
    value.bool_value, value.integer_value, value.string_array_value = flag, number, [text]
    value.double_array_value = np.array(floats)
    again = made(to_yaml(TypedValue.of(value)), message_type)
    np.testing.assert_array_equal(again.double_array_value, value.double_array_value)
    assert (again.bool_value, again.integer_value, again.string_array_value) == (flag, number, [text])
