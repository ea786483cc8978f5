"""What the helpers of cameras, lidars and radars have in common: when they publish, and with which stamps."""

from __future__ import annotations

import math
from typing import Any

import pytest

from graphengine.devices.camera import CameraStub
from graphengine.devices.lidar import LidarStub
from graphengine.devices.radar import RadarStub
from graphengine.format.errors import ContextError, PrimError
from graphengine.messages import messages
from graphengine.nodes.ros2.camera import ROS2CameraHelper
from graphengine.nodes.ros2.helper import SensorHelper
from graphengine.nodes.ros2.lidar import ROS2RtxLidarHelper
from graphengine.nodes.ros2.radar import ROS2RtxRadarHelper
from graphengine.testing import RecordingContext
from tests.nodes.harness import HelperBench, read_points, ready

SENSOR = "/robot/Geometry/base_link/Sensor"


class Bench(HelperBench):
    """A sensor of 10 samples a second, and a helper on it."""

    def __init__(self, cls: type[SensorHelper], *, wanted: bool = True, **inputs: Any) -> None:
        self.context = RecordingContext(wanted=wanted)
        self.context.world.add_robot("/robot")
        if cls is ROS2CameraHelper:
            self.sensor: Any = self.context.world.add_device(CameraStub, SENSOR, rate=10.0, size=(3, 2))
        elif cls is ROS2RtxRadarHelper:
            self.sensor = self.context.world.add_device(RadarStub, SENSOR, rate=10.0)
        else:
            self.sensor = self.context.world.add_device(LidarStub, SENSOR, rate=10.0, angles=(-1.0, 1.0, 1.0))
        self.node: Any = ready(cls, self.context, **{"render_product_path": SENSOR, **inputs})

    def sample(self, index: int = 0) -> list[Any]:
        """What is published in a tick with a sample that is full of its number."""
        self.see(index)
        return self.executed()

    def see(self, index: int) -> None:
        """A tick with a sample that is full of its number."""
        self.context.tick()
        if isinstance(self.sensor, CameraStub):
            self.sensor.show([[[index] * 3] * 3] * 2, time=self.context.clock.time, index=index)
        elif isinstance(self.sensor, RadarStub):
            self.sensor.see([[float(index)] * 3], time=self.context.clock.time, index=index)
        else:
            self.sensor.see([float(index)] * 3, time=self.context.clock.time, index=index)

    @property
    def taken(self) -> int:
        """How many samples were asked of the sensor."""
        count: int = self.sensor.requests if isinstance(self.sensor, CameraStub) else self.sensor.casts
        return count


every_helper = pytest.mark.parametrize("cls", [ROS2CameraHelper, ROS2RtxLidarHelper, ROS2RtxRadarHelper])
every_skipping_helper = pytest.mark.parametrize("cls", [ROS2CameraHelper, ROS2RtxLidarHelper])


def first_number(message: Any) -> float:
    """The first pixel, range or coordinate of a message."""
    if isinstance(message, messages.PointCloud2):
        return float(read_points(message)["x"][0])
    return float((message.ranges if isinstance(message, messages.LaserScan) else message.data)[0])


@every_helper
def test_one_execution_starts_publishing_for_all_later_ticks(cls: type[SensorHelper]) -> None:
    bench = Bench(cls)
    assert not bench.node.active
    bench.sample(1)
    for index in (2, 3):
        bench.see(index)
        bench.node.update()
    assert list(map(first_number, bench.sent)) == [1, 2, 3]


@every_helper
def test_an_execution_stops_publishing_if_disabled_and_starts_it_if_enabled(cls: type[SensorHelper]) -> None:
    bench = Bench(cls)
    for enabled in (True, False, True):
        bench.node.enabled = enabled
        bench.node.compute()
        assert bench.node.active == enabled


@every_helper
def test_a_stop_ends_publishing(cls: type[SensorHelper]) -> None:
    bench = Bench(cls)
    bench.sample()
    bench.context.stop(bench.node)
    assert not bench.node.active


@every_helper
def test_without_subscribers_no_sample_is_requested(cls: type[SensorHelper]) -> None:
    bench = Bench(cls, wanted=False)
    assert (bench.sample(), bench.taken) == ([], 0)


@every_skipping_helper
def test_frame_skip_count_skips_samples(cls: type[SensorHelper]) -> None:
    bench = Bench(cls, frame_skip_count=2)
    assert [index for index in range(9) if bench.sample(index)] == [0, 3, 6]
    assert bench.taken == 3
    assert bench.context.services.claims[0].rate == pytest.approx(10.0 / 3)


@every_helper
@pytest.mark.parametrize(("resets", "expected"), [(True, 1 / 60), (False, 1 / 60 + 1.5)])
def test_stamps_count_from_play_or_from_the_start_of_the_session(
    cls: type[SensorHelper], resets: bool, expected: float
) -> None:
    bench = Bench(cls, reset_simulation_time_on_stop=resets)
    bench.context.tick(90)
    bench.context.stop(bench.node)
    stamp = bench.sample()[0].header.stamp
    assert math.isclose(stamp.sec + stamp.nanosec * 1e-9, expected, abs_tol=1e-8)


@every_helper
def test_with_system_time_stamps_are_wall_time(cls: type[SensorHelper]) -> None:
    bench = Bench(cls, use_system_time=True)
    bench.context.clock.wall_time = 1_700_000_000.25
    stamp = bench.sample()[0].header.stamp
    # A double that counts seconds since the epoch is exact to a quarter of a microsecond.
    assert (stamp.sec, stamp.nanosec) == (1_700_000_000, pytest.approx(250_000_000, abs=256))


@every_helper
@pytest.mark.parametrize("path", ["/robot", "/nowhere", "/Render/nothing"])
def test_a_prim_that_is_not_the_sensor_is_refused_in_setup(cls: type[SensorHelper], path: str) -> None:
    with pytest.raises(PrimError):
        Bench(cls, render_product_path=path)


@every_helper
def test_in_a_graph_of_physics_steps_a_helper_is_refused_because_samples_belong_to_ticks(
    cls: type[SensorHelper],
) -> None:
    bench = Bench(cls)
    bench.context.runs = "physics_step"
    with pytest.raises(ContextError, match="runs: tick"):
        bench.node.setup(bench.context)
