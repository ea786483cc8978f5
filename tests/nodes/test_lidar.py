"""ROS2RtxLidarHelper: LaserScan and PointCloud2."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from graphengine.devices.lidar import LidarStub
from graphengine.format.errors import ContextError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.lidar import ROS2RtxLidarHelper, ROS2RtxLidarPointCloudConfig
from graphengine.testing import RecordingContext
from tests.nodes.harness import HelperBench, Player, dd100, read_points, ready

LIDAR = "/robot/Geometry/base_link/Lidar"
INF = math.inf


class Bench(HelperBench):
    """A lidar of five beams from -60 to 60 degrees, and a helper on it."""

    def __init__(self, *, wanted: bool = True, rate: float = 10.0, beams: int = 5, **inputs: Any) -> None:
        self.context = RecordingContext(wanted=wanted)
        self.context.world.add_robot("/robot")
        first, last = -math.pi / 3, math.pi / 3
        self.angles = (first, last, (last - first) / (beams - 1))
        self.lidar: LidarStub = self.context.world.add_device(
            LidarStub, LIDAR, rate=rate, angles=self.angles, ranges=(0.05, 9.0)
        )
        self.node = ready(ROS2RtxLidarHelper, self.context, **{"render_product_path": LIDAR, **inputs})

    def sample(self, ranges: Any, intensities: Any = 0.0, index: int = 0) -> list[Any]:
        """What is published in a tick with that sample, once the helper was executed."""
        self.context.tick()
        self.lidar.see(ranges, intensities, time=self.context.clock.time, index=index)
        return self.executed()


def single(values: Any) -> Any:
    """As a message holds it: with single precision."""
    return np.asarray(values, np.float32)


# LaserScan


def test_a_scan_has_one_range_per_beam_and_exactly_the_lidars_field_of_view() -> None:
    (scan,) = Bench().sample([1.0, 2.0, 3.0, 4.0, 5.0], [10, 20, 30, 40, 50])
    assert scan.ranges.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert scan.intensities.tolist() == [10.0, 20.0, 30.0, 40.0, 50.0]
    assert scan.angle_min == single(-math.pi / 3)
    assert scan.angle_max == single(math.pi / 3)
    assert scan.angle_increment == single(math.pi / 6)
    assert (scan.range_min, scan.range_max) == (single(0.05), single(9.0))


@given(beams=st.integers(2, 3000), rate=st.sampled_from((1.0, 7.0, 12.5, 20.0, 25.0)))
def test_the_last_beam_is_at_angle_max_and_the_scan_lasts_one_turn(beams: int, rate: float) -> None:
    bench = Bench(beams=beams, rate=rate)
    bench.lidar.see(np.ones(beams))
    scan = bench.node.laser_scan(bench.lidar.scan())
    assert len(scan.ranges) == len(scan.intensities) == beams
    assert scan.angle_min + (beams - 1) * scan.angle_increment == pytest.approx(scan.angle_max, abs=1e-12)
    assert scan.scan_time == 1.0 / rate


def test_the_time_increment_of_a_scan_is_0() -> None:
    (scan,) = Bench().sample([1.0] * 5)
    assert scan.time_increment == 0.0


@pytest.mark.parametrize(("no_return", "expected"), [("inf", INF), ("max", 9.0), ("minus_one", -1.0)])
def test_no_return_selects_the_range_of_a_beam_without_a_hit(no_return: str, expected: float) -> None:
    (scan,) = Bench(no_return=no_return).sample([1.0, INF, 3.0, INF, 9.0])
    assert scan.ranges.tolist() == [1.0, expected, 3.0, expected, 9.0]


def test_the_header_holds_the_samples_time_and_the_frame() -> None:
    (scan,) = Bench(frame_id="laser").sample([1.0] * 5)
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec) == (0, int(1e9 / 60))
    assert scan.header.frame_id == "laser"


@pytest.mark.parametrize("kind", ["laser_scan", "point_cloud"])
def test_messages_have_the_selected_type(kind: str) -> None:
    bench = Bench(type_in=kind)
    bench.lidar.see([1.0, INF, 3.0, 4.0, 5.0])
    scan = bench.lidar.scan()
    messages.check(bench.node.laser_scan(scan) if kind == "laser_scan" else bench.node.point_cloud(scan))


# PointCloud2


def test_a_cloud_has_the_hit_points_in_the_lidars_frame() -> None:
    (cloud,) = Bench(type_in="point_cloud").sample([1.0, INF, 2.0, INF, 3.0])
    points = read_points(cloud)
    assert list(points) == ["x", "y", "z"]
    azimuths, ranges = (-math.pi / 3, 0.0, math.pi / 3), (1.0, 2.0, 3.0)
    assert points["x"] == pytest.approx([r * math.cos(a) for a, r in zip(azimuths, ranges, strict=True)], abs=1e-6)
    assert points["y"] == pytest.approx([r * math.sin(a) for a, r in zip(azimuths, ranges, strict=True)], abs=1e-6)
    assert points["z"] == [0.0, 0.0, 0.0]
    assert (cloud.height, cloud.width, cloud.is_dense, cloud.header.frame_id) == (1, 3, True, "sim_lidar")


def test_metadata_are_fields_in_isaac_sims_order_for_any_order_of_selection() -> None:
    selected = ["ChannelId", "Timestamp", "EmitterId", "Intensity", "Timestamp"]
    bench = Bench(type_in="point_cloud", selected_metadata=selected)
    bench.context.tick(300)
    (cloud,) = bench.sample([1.0, INF, 2.0, INF, 3.0], [10, 20, 30, 40, 50])
    points = read_points(cloud)
    assert list(points) == ["x", "y", "z", "intensity", "timestamp", "emitter_id", "channel_id"]
    assert [field.datatype for field in cloud.fields] == [7, 7, 7, 7, 6, 6, 6]
    assert points["intensity"] == [10.0, 30.0, 50.0]
    assert points["emitter_id"] == [0, 2, 4]
    assert points["channel_id"] == [0, 0, 0]
    low, high = points["timestamp"][0]
    assert low + (high << 32) == int(301 / 60 * 1e9) > 2**32


def test_a_cloud_without_hits_is_empty_and_still_has_its_fields() -> None:
    (cloud,) = Bench(type_in="point_cloud", selected_metadata=["Intensity"]).sample([INF] * 5)
    assert (cloud.width, cloud.row_step, len(cloud.data)) == (0, 0, 0)
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity"]


@pytest.mark.parametrize("kind", ["LaserScan", "PointCloud2"])
def test_rosbags_reads_the_bytes_back(kind: str) -> None:
    bench = Bench(type_in={"LaserScan": "laser_scan", "PointCloud2": "point_cloud"}[kind])
    bench.sample([1.0, INF, 2.0, INF, 3.0], [10, 20, 30, 40, 50])
    (claim,) = bench.context.services.claims
    (data,) = bench.context.transport.raw(claim.topic)
    read: Any = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, f"sensor_msgs/msg/{kind}")
    if kind == "LaserScan":
        assert read.ranges.tolist() == [1.0, INF, 2.0, INF, 3.0]
        assert read.intensities.tolist() == [10.0, 20.0, 30.0, 40.0, 50.0]
    else:
        x = np.frombuffer(bytes(read.data), "<f4").reshape(-1, 3)[:, 0]
        assert x.tolist() == pytest.approx([0.5, 2.0, 1.5])


def test_unavailable_metadata_are_refused_in_setup() -> None:
    with pytest.raises(ContextError, match="HitNormal"):
        Bench(type_in="point_cloud", selected_metadata=["Intensity", "HitNormal"])


# Several rings


class Rings(Bench):
    """A lidar of two beams, straight ahead and 90 degrees to the left, on rings at 20, -1 and -15 degrees."""

    def __init__(self, **inputs: Any) -> None:
        super().__init__(**inputs)
        elevations = tuple(math.radians(angle) for angle in (20.0, -1.0, -15.0))
        lidar = "/robot/Geometry/base_link/Rings"
        self.lidar = self.context.world.add_device(
            LidarStub, lidar, rate=10.0, angles=(0.0, math.pi / 2, math.pi / 2), elevations=elevations
        )
        self.context.close()
        self.node = ready(ROS2RtxLidarHelper, self.context, **{"render_product_path": lidar, **inputs})


def test_a_scan_is_the_ring_nearest_to_the_sensors_plane() -> None:
    (scan,) = Rings().sample([1.0, 2.0, 3.0, INF, 5.0, 6.0], [10, 20, 30, 40, 50, 60])
    assert scan.ranges.tolist() == [3.0, INF]
    assert scan.intensities.tolist() == [30.0, 40.0]
    assert (scan.angle_min, scan.angle_max, scan.angle_increment) == (0.0, single(math.pi / 2), single(math.pi / 2))


def test_a_cloud_has_the_points_of_all_rings() -> None:
    bench = Rings(type_in="point_cloud", selected_metadata=["ChannelId", "EmitterId", "Intensity"])
    (cloud,) = bench.sample([1.0, INF, 3.0, INF, INF, 6.0], [10, 20, 30, 40, 50, 60])
    points = read_points(cloud)
    up, level, down = (math.radians(angle) for angle in (20.0, -1.0, -15.0))
    assert points["x"] == pytest.approx([math.cos(up), 3.0 * math.cos(level), 0.0], abs=1e-6)
    assert points["y"] == pytest.approx([0.0, 0.0, 6.0 * math.cos(down)], abs=1e-6)
    assert points["z"] == pytest.approx([math.sin(up), 3.0 * math.sin(level), 6.0 * math.sin(down)], abs=1e-6)
    assert points["channel_id"] == [0, 1, 2]
    assert points["emitter_id"] == [0, 2, 5]
    assert points["intensity"] == [10.0, 30.0, 60.0]


def test_a_cloud_for_slam_has_the_layout_of_velodynes_driver() -> None:
    """Names, datatypes (FLOAT32 is 7, UINT16 is 4) and offsets of velodyne_pointcloud's XYZIRT, 22 bytes per point."""
    bench = Rings(type_in="point_cloud", selected_metadata=["Time", "Ring", "Intensity"])
    (cloud,) = bench.sample([1.0, INF, 3.0, INF, INF, 6.0], [10, 20, 30, 40, 50, 60])
    names = ["x", "y", "z", "intensity", "ring", "time"]
    assert [field.name for field in cloud.fields] == names
    assert [(field.datatype, field.offset, field.count) for field in cloud.fields] == [
        *((7, offset, 1) for offset in (0, 4, 8, 12)),
        (4, 16, 1),
        (7, 18, 1),
    ]
    assert cloud.point_step == 22
    points = read_points(cloud)
    assert points["intensity"] == [10.0, 30.0, 60.0]
    assert points["ring"] == [0, 1, 2]
    assert points["time"] == [0.0, 0.0, 0.0]


def test_timestamps_of_points_are_the_stamp_of_the_cloud_also_without_reset_on_stop() -> None:
    bench = Bench(type_in="point_cloud", selected_metadata=["Timestamp"], reset_simulation_time_on_stop=False)
    bench.context.tick(90)
    bench.context.stop(bench.node)
    (cloud,) = bench.sample([1.0] * 5)
    ((low, high), *_) = read_points(cloud)["timestamp"]
    assert low + (high << 32) == cloud.header.stamp.sec * 10**9 + cloud.header.stamp.nanosec


# When it publishes


def test_between_two_samples_nothing_is_published() -> None:
    bench = Bench()
    bench.sample([1.0] * 5)
    bench.lidar.due = False
    bench.node.update()
    assert len(bench.sent) == 1


# Where it publishes


def test_the_namespace_is_collected_from_the_sensors_prim_and_not_from_the_nodes() -> None:
    context = RecordingContext("/World/elsewhere/Helper")
    context.world.add_robot("/robot")
    context.world.add_device(LidarStub, LIDAR)
    context.world.stage.find("/robot/base_link").namespace = "robot_1"
    context.world.stage.find(LIDAR).namespace = "laser"
    ready(ROS2RtxLidarHelper, context, render_product_path=LIDAR)
    ready(ROS2RtxLidarHelper, context, render_product_path=LIDAR, node_namespace="given")
    assert [claim.topic for claim in context.services.claims] == ["/robot_1/laser/scan", "/given/scan"]


@pytest.mark.parametrize(("kind", "name"), [("laser_scan", "LaserScan"), ("point_cloud", "PointCloud2")])
def test_the_type_selects_the_message_and_the_rate_is_the_lidars(kind: str, name: str) -> None:
    (claim,) = Bench(type_in=kind).context.services.claims
    assert (claim.message_type, claim.rate, claim.frame_id) == (f"sensor_msgs/msg/{name}", 10.0, "sim_lidar")


def test_queue_size_qos_and_domain_come_from_the_inputs() -> None:
    (claim,) = Bench(queue_size=3, context=8).context.services.claims
    assert (claim.qos, claim.ros_context) == (QoS(depth=3), 8)
    (claim,) = Bench(queue_size=3, qos_profile='{"depth": 5, "reliability": "bestEffort"}').context.services.claims
    assert claim.qos == QoS(depth=5, reliability="bestEffort")


def test_an_unknown_type_is_refused() -> None:
    with pytest.raises(ValueError, match="one of laser_scan, point_cloud"):
        Bench(type_in="depth_image")


def test_a_warning_says_that_the_object_id_map_has_no_effect() -> None:
    assert [severity for severity, _ in Bench(enable_object_id_map=True).context.logged] == ["warning"]


# In the tutorial's graph


@pytest.mark.parametrize("name", ["tutorial/scan", "dd100/scan"])
def test_shipped_graphs_publish_scans_from_the_first_tick_and_again_after_a_stop(play: Player, name: str) -> None:
    world = dd100()
    lidar = world.device(LidarStub, world.stage.find("/dd100/base_link/chassis_link/sim_lidar/Lidar"))
    lidar.see([1.0, 2.0, INF, 4.0, 5.0])
    playing = play.shipped(name, world).tick(3)
    playing.session.stop()
    playing.tick(2)
    sent = playing.published("/dd100_0000/sim_lidar/scan")
    assert len(sent) == 5
    assert all(scan.ranges.tolist() == [1.0, 2.0, INF, 4.0, 5.0] for scan in sent)


# What else a cloud's points bear


def chosen(*inputs: str) -> ROS2RtxLidarPointCloudConfig:
    return ROS2RtxLidarPointCloudConfig(**dict.fromkeys(inputs, True))


# isaacsim.ros2.nodes/python/nodes/OgnROS2RtxLidarPointCloudConfig.py, compute
def test_selected_metadata_lists_the_selected_names_in_the_order_of_the_fields() -> None:
    node = chosen("output_tick_state", "output_channel_id", "output_intensity")
    node.compute()
    assert node.selected_metadata == ("Intensity", "ChannelId", "TickState")
    isaac = [port.field for port in node.fields.values() if port.side == "inputs" and not port.extension]
    node = chosen(*isaac)
    node.compute()
    assert " ".join(node.selected_metadata) == (
        "Intensity Timestamp EmitterId ChannelId MaterialId TickId HitNormal Velocity ObjectId EchoId TickState"
    )


def test_ring_and_time_are_chosen_like_other_metadata() -> None:
    node = chosen("output_time", "output_ring", "output_intensity")
    node.compute()
    assert node.selected_metadata == ("Intensity", "Ring", "Time")


def test_in_a_graph_a_cloud_has_the_metadata_that_the_config_node_selects(play: Player) -> None:
    world = dd100()
    lidar = world.device(LidarStub, world.stage.find("/dd100/base_link/chassis_link/sim_lidar/Lidar"))
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Config: {type: RtxLidarPointCloudConfig, inputs: {outputIntensity: true}}
          Helper:
            type: RtxLidarHelper
            inputs: {type: point_cloud, renderProductPath: /dd100/base_link/chassis_link/sim_lidar/Lidar, topicName: cloud}
        connections: [Tick.tick -> Helper.execIn, Config.selectedMetadata -> Helper.selectedMetadata]
        """,
        world,
    )
    lidar.see([1.0] * 5, 100.0)
    playing.tick()
    (cloud,) = playing.published(playing.topics["Helper"])
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity"]
