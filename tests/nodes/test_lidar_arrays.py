"""IsaacComputeRTXLidarFlatScan, IsaacReadLidarBeams and IsaacReadLidarPointCloud: a lidar's samples as arrays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.lidar import LidarStub
from graphengine.format.errors import ContextError, PrimError
from graphengine.nodes.lidar import (
    IsaacComputeRTXLidarFlatScan,
    IsaacReadLidarBeams,
    IsaacReadLidarPointCloud,
    LidarNode,
)
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, dd100, read_points, ready

LIDAR = "/robot/Geometry/base_link/Lidar"
INF = math.inf
INPUTS: dict[type[LidarNode], str] = {
    IsaacComputeRTXLidarFlatScan: "render_product_path",
    IsaacReadLidarBeams: "lidar_prim",
    IsaacReadLidarPointCloud: "lidar_prim",
}

every_node = pytest.mark.parametrize("cls", INPUTS)


class Bench:
    """A lidar of three beams from -60 to 60 degrees, and a node on it; by default with rings at 30, 2 and -10 degrees."""

    def __init__(
        self, cls: type[LidarNode], elevations: tuple[float, ...] = (30.0, 2.0, -10.0), path: str = LIDAR
    ) -> None:
        self.context = RecordingContext()
        self.context.world.add_robot("/robot")
        first, last = -math.pi / 3, math.pi / 3
        self.lidar: LidarStub = self.context.world.add_device(
            LidarStub,
            LIDAR,
            rate=20.0,
            angles=(first, last, (last - first) / 2),
            ranges=(0.05, 9.0),
            elevations=tuple(math.radians(angle) for angle in elevations),
        )
        self.node: Any = ready(cls, self.context, **{INPUTS[cls]: path})
        self.index = 0

    def sample(self, ranges: list[float], intensities: Any = 0.0) -> bool:
        """Whether the node fires in a tick with that sample."""
        self.context.tick()
        self.lidar.see(ranges, intensities, time=self.context.clock.time, index=self.index)
        self.index += 1
        return self.node.compute() is not None


NINE = [1.0, 2.0, 3.0, 4.0, INF, 6.0, 7.0, 8.0, 9.0]


# Beams


def test_the_flat_scan_is_the_ring_nearest_to_the_sensors_plane() -> None:
    bench = Bench(IsaacComputeRTXLidarFlatScan)
    assert bench.sample(NINE, [0, 10, 20, 30, 40, 50, 60, 70, 255])
    assert bench.node.linear_depth_data.tolist() == [4.0, INF, 6.0]
    assert bench.node.intensities_data.tolist() == [30, 40, 50]
    assert (bench.node.num_rows, bench.node.num_cols) == (1, 3)


def test_beams_are_output_ring_by_ring() -> None:
    bench = Bench(IsaacReadLidarBeams)
    assert bench.sample(NINE, [0, 10, 20, 30, 40, 50, 60, 70, 255])
    assert bench.node.linear_depth_data.tolist() == NINE
    assert bench.node.intensities_data.tolist() == [0, 10, 20, 30, 40, 50, 60, 70, 255]
    assert (bench.node.num_rows, bench.node.num_cols) == (3, 3)
    assert bench.node.beam_time_data.tolist() == [0.0] * 9


@pytest.mark.parametrize("cls", [IsaacComputeRTXLidarFlatScan, IsaacReadLidarBeams])
def test_angles_are_in_degrees_and_ranges_and_rate_are_the_lidars(cls: type[LidarNode]) -> None:
    bench = Bench(cls)
    bench.sample(NINE)
    assert bench.node.azimuth_range == pytest.approx((-60.0, 60.0))
    assert (bench.node.horizontal_fov, bench.node.horizontal_resolution) == pytest.approx((120.0, 60.0))
    assert (bench.node.depth_range, bench.node.rotation_rate) == ((0.05, 9.0), 20.0)


def test_elevations_are_degrees_from_the_lowest_ring_to_the_highest() -> None:
    bench = Bench(IsaacReadLidarBeams)
    bench.sample(NINE)
    assert bench.node.zenith_range == pytest.approx((-10.0, 30.0))
    assert (bench.node.vertical_fov, bench.node.vertical_resolution) == pytest.approx((40.0, 20.0))


def test_a_planar_lidar_has_no_height() -> None:
    bench = Bench(IsaacReadLidarBeams, (0.0,))
    bench.sample([1.0, 2.0, 3.0])
    assert (bench.node.num_rows, bench.node.vertical_fov, bench.node.vertical_resolution) == (1, 0.0, 0.0)
    assert bench.node.zenith_range == (0.0, 0.0)


def test_intensities_are_rounded_to_whole_numbers() -> None:
    bench = Bench(IsaacReadLidarBeams, (0.0,))
    bench.sample([1.0, 2.0, 3.0], [0.4, 127.6, 255.0])
    assert bench.node.intensities_data.dtype == np.uint8
    assert bench.node.intensities_data.tolist() == [0, 128, 255]


# Points


def test_points_are_the_hits_of_the_beams_in_the_lidars_frame() -> None:
    bench = Bench(IsaacReadLidarPointCloud)
    assert bench.sample([INF, 2.0, INF, INF, INF, INF, 5.0, INF, INF])
    up, down = math.radians(30.0), math.radians(-10.0)
    azimuth = -math.pi / 3
    expected = [
        [2.0 * math.cos(up), 0.0, 2.0 * math.sin(up)],
        [5.0 * math.cos(down) * math.cos(azimuth), 5.0 * math.cos(down) * math.sin(azimuth), 5.0 * math.sin(down)],
    ]
    assert bench.node.data.dtype == np.float32
    assert np.allclose(bench.node.data, expected, atol=1e-6)


def test_without_a_hit_there_are_no_points() -> None:
    bench = Bench(IsaacReadLidarPointCloud)
    assert bench.sample([INF] * 9)
    assert bench.node.data.shape == (0, 3)


# When they fire


@every_node
def test_each_sample_fires_once_however_often_the_node_is_executed(cls: type[LidarNode]) -> None:
    bench = Bench(cls)
    assert bench.sample(NINE)
    assert bench.node.compute() is None
    assert bench.sample(NINE)


@every_node
def test_between_two_samples_nothing_fires_and_no_rays_are_cast(cls: type[LidarNode]) -> None:
    bench = Bench(cls)
    bench.sample(NINE)
    casts, bench.lidar.due = bench.lidar.casts, False
    bench.context.tick()
    assert bench.node.compute() is None
    assert bench.lidar.casts == casts


@every_node
def test_after_a_stop_the_first_sample_fires_again(cls: type[LidarNode]) -> None:
    bench = Bench(cls)
    bench.sample(NINE)
    bench.context.stop(bench.node)
    bench.index = 0
    assert bench.sample(NINE)


@every_node
def test_an_output_array_is_never_overwritten(cls: type[LidarNode]) -> None:
    bench = Bench(cls)
    port = "data" if cls is IsaacReadLidarPointCloud else "linear_depth_data"
    bench.sample(NINE)
    first = getattr(bench.node, port)
    before = first.copy()
    bench.sample([0.5] * 9)
    assert np.array_equal(first, before)


@every_node
@pytest.mark.parametrize("path", ["/robot", "/nowhere"])
def test_a_prim_that_is_not_a_lidar_is_refused_in_setup(cls: type[LidarNode], path: str) -> None:
    with pytest.raises(PrimError):
        Bench(cls, path=path)


@every_node
def test_in_a_graph_of_physics_steps_a_lidar_node_is_refused_because_samples_belong_to_ticks(
    cls: type[LidarNode],
) -> None:
    context = RecordingContext()
    context.world.add_device(LidarStub, "/Lidar")
    context.runs = "physics_step"
    with pytest.raises(ContextError, match="runs: tick"):
        ready(cls, context, **{INPUTS[cls]: "/Lidar"})


@every_node
def test_a_node_reads_the_lidar_that_is_set_while_the_graph_runs(cls: type[LidarNode], play: Player) -> None:
    world = RecordingWorld()
    for path, beams in (("/Left", [1.0]), ("/Right", [2.0])):
        world.add_device(LidarStub, path).see(beams)
    port, pulse = cls.fields[INPUTS[cls]].name, cls.fields["exec_in"].name
    playing = play.graph(
        f"""
        nodes: {{Tick: OnPlaybackTick, Read: {{type: {cls.type_name}, inputs: {{{port}: /Left}}}}}}
        connections: [Tick.tick -> Read.{pulse}]
        """,
        world,
    ).tick()
    before = playing.node("Read").lidar.scan().ranges.tolist()
    playing.command("set", address=f"Read.{port}", value="/Right")
    assert (before, playing.node("Read").lidar.scan().ranges.tolist()) == ([1.0], [2.0])


# With the publishers

SCAN = """
    nodes:
      Tick: OnPlaybackTick
      Product: {type: CreateRenderProduct, inputs: {cameraPrim: /dd100/base_link/chassis_link/sim_lidar/Lidar}}
      Flat: ComputeRTXLidarFlatScan
      Cloud: {type: ReadLidarPointCloud, inputs: {lidarPrim: /dd100/base_link/chassis_link/sim_lidar/Lidar}}
      Scan: PublishLaserScan
      Points: PublishPointCloud
      Helper: RtxLidarHelper
    connections:
      - Tick.tick -> Product.execIn
      - Product.execOut -> Flat.exec
      - Product.execOut -> Helper.execIn
      - Product.renderProductPath -> Flat.renderProductPath
      - Product.renderProductPath -> Helper.renderProductPath
      - Flat.outputs:exec -> Scan.execIn
      - Flat.linearDepthData -> Scan.linearDepthData
      - Flat.intensitiesData -> Scan.intensitiesData
      - Flat.azimuthRange -> Scan.azimuthRange
      - Flat.horizontalFov -> Scan.horizontalFov
      - Flat.horizontalResolution -> Scan.horizontalResolution
      - Flat.depthRange -> Scan.depthRange
      - Flat.numRows -> Scan.numRows
      - Flat.numCols -> Scan.numCols
      - Tick.time -> Scan.timeStamp
      - Tick.tick -> Cloud.execIn
      - Cloud.execOut -> Points.execIn
      - Cloud.data -> Points.data
    """


def test_in_a_graph_the_arrays_make_the_scan_that_the_helper_makes(play: Player) -> None:
    world = dd100()
    lidar = world.device(LidarStub, world.stage.find("/dd100/base_link/chassis_link/sim_lidar/Lidar"))
    lidar.see([1.0, 2.0, INF, 4.0, 5.0], [0.0, 50.0, 0.0, 100.0, 255.0], time=1 / 60)
    playing = play.graph(SCAN, world).tick()
    (scan,), (expected,) = (playing.published(topic) for topic in ("/scan", "/dd100_0000/sim_lidar/scan"))
    assert scan.ranges.tolist() == expected.ranges.tolist()
    assert scan.intensities.tolist() == expected.intensities.tolist()
    for name in ("angle_min", "angle_max", "angle_increment", "range_min", "range_max", "time_increment"):
        assert getattr(scan, name) == pytest.approx(getattr(expected, name), abs=1e-6), name
    (cloud,) = playing.published("/point_cloud")
    points = read_points(cloud)
    assert list(map(math.hypot, points["x"], points["y"])) == pytest.approx([1.0, 2.0, 4.0, 5.0])
