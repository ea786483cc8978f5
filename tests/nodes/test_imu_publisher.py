"""ROS2PublishImu: a reading, and what of it is left out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graphengine.devices.imu import ImuSample, ImuStub
from graphengine.messages import messages
from graphengine.node import BadValueError
from graphengine.nodes.ros2.imu import ROS2PublishImu
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, dd100, quaternion, ready, vector

TURN, ACCELERATION, RATE = (0.5, -0.5, 0.5, 0.5), (1.0, 2.0, 9.81), (0.1, 0.2, 0.3)
PARTS = ("orientation", "linear_acceleration", "angular_velocity")


def reading(**inputs: Any) -> messages.Imu:
    """The message of a reading."""
    measured = {"orientation": TURN, "linear_acceleration": ACCELERATION, "angular_velocity": RATE}
    return ready(ROS2PublishImu, RecordingContext(), **measured, **inputs).message()


def test_a_reading_is_published_unchanged_with_covariances_of_zero() -> None:
    imu = reading(frame_id="imu_link", time_stamp=2.5)
    messages.check(imu)
    assert (quaternion(imu.orientation), vector(imu.linear_acceleration), vector(imu.angular_velocity)) == (
        TURN,
        ACCELERATION,
        RATE,
    )
    assert all(getattr(imu, f"{part}_covariance").tolist() == [0.0] * 9 for part in PARTS)
    assert (imu.header.frame_id, imu.header.stamp.sec, imu.header.stamp.nanosec) == ("imu_link", 2, 500_000_000)


@pytest.mark.parametrize("part", PARTS)
def test_an_unpublished_quantity_is_zero_with_a_covariance_of_minus_1(part: str) -> None:
    imu = reading(**{f"publish_{part}": False})
    messages.check(imu)
    left_out = getattr(imu, part)
    numbers = quaternion(left_out) if part == "orientation" else vector(left_out)
    assert set(numbers) == {0.0}
    assert getattr(imu, f"{part}_covariance").tolist() == [-1.0] + [0.0] * 8
    others = [other for other in PARTS if other != part]
    assert all(getattr(imu, f"{other}_covariance").tolist() == [0.0] * 9 for other in others)


@pytest.mark.parametrize("part", PARTS)
def test_a_given_covariance_is_published_unless_its_quantity_is_left_out(part: str) -> None:
    given = {f"{part}_covariance": np.arange(1.0, 10.0)}
    assert getattr(reading(**given), f"{part}_covariance").tolist() == list(range(1, 10))
    left_out = getattr(reading(**given, **{f"publish_{part}": False}), f"{part}_covariance")
    assert left_out.tolist() == [-1.0] + [0.0] * 8
    with pytest.raises(BadValueError, match="Covariance must be 9 numbers, or empty"):
        reading(**{f"{part}_covariance": np.zeros(36)})


def test_the_default_reading_is_upright_and_at_rest() -> None:
    imu = ready(ROS2PublishImu, RecordingContext()).message()
    assert quaternion(imu.orientation) == (0.0, 0.0, 0.0, 1.0)
    assert vector(imu.linear_acceleration) == vector(imu.angular_velocity) == (0.0, 0.0, 0.0)


def test_the_shipped_graph_publishes_each_sample_once_with_its_stamp_and_frame(play: Player) -> None:
    world = dd100()
    imu = world.add_device(ImuStub, "/dd100/Geometry/base_link/chassis_link/sim_camera/RSD455/Imu_Sensor")
    imu.measured = ImuSample(0.25, 7, (1.0, 2.0, 3.0), (0.0, 0.0, 9.81), (4.0, 5.0, 6.0), TURN)
    playing = play.shipped("imu", world).tick(3)
    (message,) = playing.published("/dd100_0000/sim_camera/imu")
    assert (message.header.frame_id, message.header.stamp.nanosec) == ("Imu_Sensor", 250_000_000)
    assert vector(message.linear_acceleration) == pytest.approx((1.0, 2.0, 12.81))
    assert (vector(message.angular_velocity), quaternion(message.orientation)) == ((4.0, 5.0, 6.0), TURN)
    (tree,) = playing.published("/dd100_0000/tf_static")
    assert [(t.header.frame_id, t.child_frame_id) for t in tree.transforms] == [("base_link", "Imu_Sensor")]
