"""Patched bytes are the encoder's bytes, whatever the numbers; what differs in more than numbers is encoded the general way."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages import messages
from graphengine.messages.message_template import Encoder, Template

doubles = st.floats(width=64)
triples = st.tuples(doubles, doubles, doubles)
quadruples = st.tuples(doubles, doubles, doubles, doubles)
times = st.floats(0, 1e6)
frames = st.sampled_from(["", "odom", "base_link", "map\N{DEGREE SIGN}", "a_rather_long_frame_id"])

CONSTANT = np.arange(36.0)
CONSTANT.setflags(write=False)


def transform(time: float, parent: str, child: str, p: Any, q: Any) -> messages.TransformStamped:
    pose = messages.Transform(messages.Vector3(*p), messages.Quaternion(*q))
    return messages.TransformStamped(messages.header(time, parent), child, pose)


def odometry(time: float, frame: str, p: Any, q: Any, v: Any, w: Any) -> messages.Odometry:
    pose = messages.PoseWithCovariance(messages.Pose(messages.Point(*p), messages.Quaternion(*q)), CONSTANT)
    twist = messages.TwistWithCovariance(messages.Twist(messages.Vector3(*v), messages.Vector3(*w)), CONSTANT)
    return messages.Odometry(messages.header(time, frame), "base_link", pose, twist)


def scan(ranges: Any, intensities: Any) -> messages.LaserScan:
    header = messages.header(0.0, "lidar")
    return messages.LaserScan(header, 0.0, 1.0, 0.1, 0.0, 0.1, 0.0, 9.0, ranges, intensities)


def template_of(message: Any) -> Template:
    template = Template.of(message)
    assert template is not None
    return template


odometries = st.builds(odometry, times, frames, triples, quadruples, triples, triples)
edges = st.builds(transform, times, frames, frames, triples, quadruples)
trees = st.builds(messages.TFMessage, st.lists(edges, max_size=4))
clocks = st.builds(lambda time: messages.Clock(messages.stamp(time)), times)
arrays = st.lists(doubles, max_size=3).map(np.array).map(lambda array: array.astype(float))
names = st.lists(frames, max_size=3)
joint_states = st.builds(messages.JointState, st.builds(messages.header, times, frames), names, arrays, arrays, arrays)
twists = st.builds(lambda v, w: messages.Twist(messages.Vector3(*v), messages.Vector3(*w)), triples, triples)


@pytest.mark.parametrize("kind", [odometries, trees, clocks, twists, joint_states])
@given(data=st.data())
def test_each_message_of_a_stream_gets_the_bytes_of_the_general_encoder(
    kind: st.SearchStrategy[Any], data: st.DataObject
) -> None:
    encoder = Encoder()
    for message in data.draw(st.lists(kind, min_size=1, max_size=12)):
        assert encoder.encode(message) == messages.encode(message)


def test_a_template_encodes_only_messages_that_differ_in_numbers() -> None:
    first = odometry(1.0, "odom", (1, 2, 3), (0, 0, 0, 1), (4, 5, 6), (7, 8, 9))
    template = template_of(first)
    other = odometry(2.5, "odom", (3, 2, 1), (0, 0, 1, 0), (6, 5, 4), (9, 8, 7))
    assert template.encode(other) == messages.encode(other)
    assert template.encode(odometry(2.5, "map", (3, 2, 1), (0, 0, 1, 0), (6, 5, 4), (9, 8, 7))) is None


@pytest.mark.parametrize("writeable", [False, True])
def test_arrays_of_fixed_length_are_read_for_each_message(writeable: bool) -> None:
    message = odometry(1.0, "odom", (1, 2, 3), (0, 0, 0, 1), (4, 5, 6), (7, 8, 9))
    values = np.zeros(36)
    message.pose.covariance = values.view()
    message.pose.covariance.flags.writeable = writeable
    template = template_of(message)
    values[7] = 0.25
    assert template.encode(message) == messages.encode(message)
    message.pose.covariance = np.ones(36)
    assert template.encode(message) == messages.encode(message)


def test_an_array_of_another_shape_raises_the_error_of_the_general_encoder() -> None:
    message = odometry(1.0, "odom", (1, 2, 3), (0, 0, 0, 1), (4, 5, 6), (7, 8, 9))
    encoder = Encoder()
    encoder.encode(message)
    message.pose.covariance = np.ones((6, 6))
    with pytest.raises(messages.MessageError):
        encoder.encode(message)


def test_a_large_array_is_copied_only_once() -> None:
    message = scan(np.zeros(2751, np.float32), np.zeros(2751, np.float32))
    template = template_of(message)
    ranges = np.linspace(0.5, 9.0, 2751, dtype=np.float32)
    other = scan(ranges, ranges * 2)
    tracemalloc.start()
    data = template.encode(other)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert data == messages.encode(other)
    assert peak < ranges.nbytes * 2 + 1000


@pytest.mark.parametrize("pixels", [0, 1, 3, 1023, 1024, 1025, 4098])
def test_fields_behind_an_array_of_any_length_are_encoded(pixels: int) -> None:
    fields = [messages.PointField("x", 0, messages.PointField.FLOAT32, 1)]
    data = np.arange(pixels).astype(np.uint8)
    cloud = messages.PointCloud2(messages.header(0.0, "lidar"), 1, pixels, fields, False, 1, pixels, data, False)
    template = template_of(cloud)
    cloud.data, cloud.is_dense, cloud.height = data[::-1].copy(), True, 2
    assert template.encode(cloud) == messages.encode(cloud)


@pytest.mark.parametrize("other", [np.zeros(2750, np.float32), np.zeros(2752, np.float32), np.zeros(2751, np.int32)])
def test_the_general_encoder_encodes_a_large_array_of_another_type_or_length(other: Any) -> None:
    ranges = np.zeros(2751, np.float32)
    encoder, message = Encoder(), scan(ranges, ranges)
    encoder.encode(message)
    template = template_of(message)
    message.ranges = other
    assert template.encode(message) is None
    assert encoder.encode(message) == messages.encode(message)


def test_a_large_array_that_is_not_contiguous_raises_the_error_of_the_general_encoder() -> None:
    ranges = np.zeros(2751, np.float32)
    encoder = Encoder()
    encoder.encode(scan(ranges, ranges))
    with pytest.raises(messages.MessageError, match="non-contiguous"):
        encoder.encode(scan(np.zeros(5502, np.float32)[::2], ranges))


def test_the_general_encoder_encodes_an_array_of_another_type() -> None:
    joints = messages.JointState(messages.header(0.0, ""), ["a", "b"], np.ones(2), np.ones(2), np.ones(2))
    template = template_of(joints)
    other: Any = np.ones(2, np.float32)
    joints.position = other
    assert template.encode(joints) is None


def test_names_that_are_changed_in_place_are_noticed() -> None:
    encoder = Encoder()
    joints = messages.JointState(messages.header(0.0, ""), ["a", "b"], np.ones(2), np.ones(2), np.ones(2))
    encoder.encode(joints)
    joints.name[0] = "c"
    assert encoder.encode(joints) == messages.encode(joints)


def test_returned_bytes_do_not_change_later() -> None:
    encoder = Encoder()
    encoder.encode(messages.Clock(messages.stamp(1.0)))
    second = encoder.encode(messages.Clock(messages.stamp(2.0)))
    kept = bytes(second)
    encoder.encode(messages.Clock(messages.stamp(3.0)))
    assert second == kept


def test_a_field_of_a_wrong_type_raises_the_error_of_the_general_encoder() -> None:
    encoder = Encoder()
    encoder.encode(messages.Clock(messages.stamp(1.0)))
    with pytest.raises(messages.MessageError):
        encoder.encode(messages.Clock(messages.Time("now", 0)))  # type: ignore[arg-type]
