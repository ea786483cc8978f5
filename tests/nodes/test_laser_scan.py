"""ROS2PublishLaserScan: a row of ranges from arrays. What Isaac Sim's tests assert is in isaac/lidar.py."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.nodes.ros2.laser_scan import ROS2PublishLaserScan
from graphengine.testing import RecordingContext
from tests.nodes.harness import ready

INF = math.inf


def row(ranges: list[float], **inputs: Any) -> ROS2PublishLaserScan:
    """A node with that row."""
    given = {"linear_depth_data": ranges, "num_rows": 1, "num_cols": len(ranges), **inputs}
    return ready(ROS2PublishLaserScan, RecordingContext(), **given)


def test_angles_are_given_in_degrees_and_sent_in_radians() -> None:
    scan = row(
        [1.0, INF, 3.0], azimuth_range=(-90.0, 90.0), horizontal_resolution=90.0, depth_range=(0.5, 9.0)
    ).message()
    messages.check(scan)
    assert (scan.angle_min, scan.angle_max, scan.angle_increment) == pytest.approx(
        (-math.pi / 2, math.pi / 2, math.pi / 2)
    )
    assert scan.ranges.tolist() == [1.0, INF, 3.0]
    assert (scan.range_min, scan.range_max) == (0.5, 9.0)


def test_scan_time_is_1_by_the_rate_and_time_increment_the_share_of_a_beam() -> None:
    scan = row([1.0] * 90, horizontal_fov=180.0, rotation_rate=10.0).message()
    assert scan.scan_time == pytest.approx(0.1)
    assert scan.time_increment == pytest.approx(0.05 / 90)


def test_intensities_are_0_to_255() -> None:
    scan = row([1.0, 2.0, INF], intensities_data=[0, 128, 255]).message()
    assert scan.intensities.dtype == np.float32
    assert scan.intensities.tolist() == [0.0, 128.0, 255.0]


def test_without_intensities_hits_have_255_and_misses_0() -> None:
    assert row([1.0, INF, 0.0, -1.0, 2.0]).message().intensities.tolist() == [255.0, 0.0, 0.0, 0.0, 255.0]


@pytest.mark.parametrize("rows", [0, 2, 16])
def test_a_number_of_rows_other_than_one_is_an_error(rows: int) -> None:
    with pytest.raises(ValueError, match=f"numRows must be 1, because a LaserScan is one row of beams, it is {rows}"):
        row([1.0, 2.0], num_rows=rows).message()


@pytest.mark.parametrize(("ranges", "columns"), [([], 0), ([1.0, 2.0], 3)])
def test_a_number_of_ranges_other_than_num_cols_is_an_error(ranges: list[float], columns: int) -> None:
    with pytest.raises(
        ValueError, match=rf"a non-empty array of ranges and its length, it is \[{len(ranges)}, {columns}\]"
    ):
        row(ranges, num_cols=columns).message()


def test_a_number_of_intensities_other_than_the_beams_is_an_error() -> None:
    with pytest.raises(
        ValueError, match=r"intensitiesData, linearDepthData must be one intensity per beam, it is \[1, 2\]"
    ):
        row([1.0, 2.0], intensities_data=[1]).message()
