"""Expressions of `graphrun topic echo --filter` on messages."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.cli.topic_subscription import make_filter
from graphengine.format.errors import UsageError
from graphengine.messages import messages

SCAN = messages.message_class("sensor_msgs/msg/LaserScan")(
    header=messages.Header(messages.Time(7, 5), "laser"),
    angle_min=-1.0,
    angle_max=1.0,
    angle_increment=1.0,
    time_increment=0.0,
    scan_time=0.1,
    range_min=0.1,
    range_max=9.0,
    ranges=np.array([0.5, math.inf, 2.0], np.float32),
    intensities=np.array([], np.float32),
)


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("any(r < 0.6 for r in m.ranges)", True),
        ("min(m.ranges) < m.range_min or m.ranges.min() > 1", False),
        ("len([r for r in m.ranges if isinf(r)]) == 1", True),
        ("m.ranges[1:].max() > m.range_max", True),
        ("m.header.frame_id.startswith('las') and 'x' not in m.header.frame_id", True),
        ("m.header.stamp.sec + m.header.stamp.nanosec * 1e-9 > 7.1", False),
        ("abs(m.angle_min) == m.angle_max", True),
        ("hypot(m.ranges[0], m.ranges[2]) < 2", False),
        ("(m.ranges[::2] * 2 > 1).all()", False),
        ("m.intensities.size or m.ranges.tolist()[0] == 0.5", True),
    ],
)
def test_a_filter_wants_the_messages_of_which_its_expression_is_true(expression: str, wanted: bool) -> None:
    assert make_filter(expression)(SCAN) is wanted
    assert make_filter(None)(SCAN)


@pytest.mark.parametrize(
    "expression",
    ["m.__class__", "m.__msgtype__", "m.ranges.tofile('x')", "m.ranges.ctypes", "m.ranges.__array_interface__"],
)
def test_a_filter_reads_the_fields_of_messages_alone(expression: str) -> None:
    with pytest.raises(UsageError, match="is not allowed in an expression"):
        make_filter(expression)(SCAN)
