"""IsaacCreateRTXLidarScanBuffer and OgnIsaacExtractRTXSensorPointCloud: points of lidars and radars as buffers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.devices.lidar import LidarStub
from graphengine.devices.radar import RadarStub
from graphengine.format.errors import ContextError, PrimError
from graphengine.nodes.point_buffers import IsaacCreateRTXLidarScanBuffer, OgnIsaacExtractRTXSensorPointCloud
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, read_points, ready, yaw

LINK = "/robot/Geometry/base_link"
LIDAR, RADAR = f"{LINK}/Lidar", f"{LINK}/Radar"
INF = math.inf
RANGES = [1.0, 2.0, INF, 4.0, 5.0, 6.0]
HIT = [0, 1, 3, 4, 5]
POINTS = [[3.0, 4.0, 0.0], [0.0, 0.0, 2.0]]
DTYPES: dict[str, Any] = dict.fromkeys(
    ("azimuth", "elevation", "distance", "intensity", "radialVelocityMS"), np.float32
)
DTYPES |= {"timestamp": np.uint64, "emitterId": np.uint32, "channelId": np.uint32}
EVERY = ["azimuth", "elevation", "distance", "intensity", "timestamp", "emitterId", "channelId"]
EVERY += ["materialId", "tickId", "hitNormal", "velocity", "objectId", "echoId", "tickState", "radialVelocityMS"]

every_node = pytest.mark.parametrize("cls", [OgnIsaacExtractRTXSensorPointCloud, IsaacCreateRTXLidarScanBuffer])


class Bench:
    """A lidar of two rings of three beams and a radar, on a robot at (1, 2) that is turned to the left."""

    def __init__(self) -> None:
        self.context = RecordingContext()
        self.context.world.add_robot("/robot")
        self.context.world.body(self.context.world.stage.find("/robot")).place((1.0, 2.0, 0.0), yaw(math.pi / 2))
        angles, rings = (-math.pi / 3, math.pi / 3, math.pi / 3), (0.0, math.radians(30.0))
        self.lidar = self.context.world.add_device(LidarStub, LIDAR, rate=20.0, angles=angles, elevations=rings)
        self.radar = self.context.world.add_device(RadarStub, RADAR, rate=20.0)

    def see(self, index: int = 0) -> None:
        self.context.tick()
        self.lidar.see(RANGES, [10, 20, 0, 40, 50, 60], time=1.5, index=index)
        self.radar.see(POINTS, [-1.0, 2.0], [30.0, 40.0], time=1.5, index=index)

    def sampled(self, cls: type[Any], path: str, **inputs: Any) -> Any:
        """A node that has output a sample."""
        node = ready(cls, self.context, render_product_path=path, **inputs)
        self.see()
        assert node.compute() is cls.exec_out
        return node


def output(node: Any, name: str) -> Any:
    return getattr(node, type(node).ports[f"outputs:{name}"].field)


def array(node: Any, name: str) -> NDArray[Any] | None:
    """The buffer of some metadata, which has the size that the node says; None without one."""
    buffer, size = output(node, f"{name}Ptr"), output(node, f"{name}BufferSize")
    assert size == (0 if isinstance(buffer, int) else memoryview(buffer).nbytes)
    return None if isinstance(buffer, int) else np.frombuffer(memoryview(buffer), DTYPES[name])


def points(node: Any) -> NDArray[Any]:
    found = np.frombuffer(memoryview(node.data_ptr_out), np.float32).reshape(-1, 3)
    assert (node.width, node.height, node.buffer_size) == (len(found), 1, found.nbytes)
    return found


def selecting(*names: str) -> dict[str, bool]:
    """Inputs that select metadata."""
    ports = IsaacCreateRTXLidarScanBuffer.ports
    return {ports[f"inputs:output{name[0].upper()}{name[1:]}"].field: True for name in names}


@every_node
def test_azimuth_elevation_and_distance_give_the_hit_points_of_the_beams(cls: type[Any]) -> None:
    node = Bench().sampled(cls, LIDAR)
    azimuths, elevations = [-60.0, 0.0, -60.0, 0.0, 60.0], [0.0, 0.0, 30.0, 30.0, 30.0]
    distances = np.array(RANGES)[HIT]
    level = distances * np.cos(np.radians(elevations))
    expected = np.stack(
        [
            level * np.cos(np.radians(azimuths)),
            level * np.sin(np.radians(azimuths)),
            distances * np.sin(np.radians(elevations)),
        ],
        axis=1,
    )
    np.testing.assert_allclose(points(node), expected, atol=1e-4)  # the tolerance of Isaac Sim's own test


def test_all_metadata_that_rays_provide_is_output_for_a_lidar() -> None:
    node = Bench().sampled(OgnIsaacExtractRTXSensorPointCloud, LIDAR)
    found = {name: values for name in EVERY if (values := array(node, name)) is not None}
    assert set(found) == {"azimuth", "elevation", "distance", "intensity", "timestamp", "emitterId", "channelId"}
    np.testing.assert_allclose(found["azimuth"], [-60, 0, -60, 0, 60], atol=1e-4)
    np.testing.assert_allclose(found["elevation"], [0, 0, 30, 30, 30], atol=1e-4)
    np.testing.assert_allclose(found["distance"], [1, 2, 4, 5, 6], atol=1e-5)
    assert found["intensity"].tolist() == [10, 20, 40, 50, 60]
    assert found["timestamp"].tolist() == [1_500_000_000] * 5
    assert (found["emitterId"].tolist(), found["channelId"].tolist()) == (HIT, [0, 0, 1, 1, 1])


def test_all_metadata_that_rays_provide_is_output_for_a_radar() -> None:
    node = Bench().sampled(OgnIsaacExtractRTXSensorPointCloud, RADAR)
    found = {name: values for name in EVERY if (values := array(node, name)) is not None}
    assert set(found) == {"azimuth", "elevation", "distance", "intensity", "timestamp", "radialVelocityMS"}
    np.testing.assert_allclose(points(node), POINTS)
    np.testing.assert_allclose(found["azimuth"], [math.degrees(math.atan2(4, 3)), 0.0], atol=1e-4)
    np.testing.assert_allclose(found["elevation"], [0.0, 90.0], atol=1e-4)
    np.testing.assert_allclose(found["distance"], [5.0, 2.0])
    assert (found["radialVelocityMS"].tolist(), found["intensity"].tolist()) == ([-1.0, 2.0], [30.0, 40.0])


@pytest.mark.parametrize(
    "chosen", [(), ("distance",), ("azimuth", "intensity", "timestamp"), ("emitterId", "channelId")]
)
def test_a_scan_buffer_has_the_metadata_that_is_selected(chosen: tuple[str, ...]) -> None:
    node = Bench().sampled(IsaacCreateRTXLidarScanBuffer, LIDAR, **selecting(*chosen))
    assert [name for name in EVERY if array(node, name) is not None] == [name for name in EVERY if name in chosen]


def test_a_scan_buffer_warns_about_metadata_that_rays_do_not_provide() -> None:
    bench = Bench()
    ready(
        IsaacCreateRTXLidarScanBuffer,
        bench.context,
        render_product_path=LIDAR,
        **selecting("hitNormal", "intensity", "echoId"),
    )
    assert bench.context.logged == [
        (
            "warning",
            "ray casting does not provide the metadata of these inputs, so they have no effect: outputHitNormal, outputEchoId",
        )
    ]


@every_node
def test_the_transform_is_the_pose_of_the_sensor_as_a_matrix_for_row_vectors(cls: type[Any]) -> None:
    node = Bench().sampled(cls, LIDAR)
    expected = [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [1, 2, 0, 1]]
    np.testing.assert_allclose(np.reshape(node.transform, (4, 4)), expected, atol=1e-12)


@every_node
@pytest.mark.parametrize("path", [LIDAR, RADAR])
def test_a_point_buffer_node_fires_once_per_sample(cls: type[Any], path: str) -> None:
    bench = Bench()
    node = ready(cls, bench.context, render_product_path=path)
    assert node.compute() is None
    fired = []
    for index in (0, 0, 1):
        bench.see(index)
        fired.append(node.compute())
    assert fired == [cls.exec_out, None, cls.exec_out]


@every_node
def test_a_sample_without_a_hit_is_an_empty_buffer(cls: type[Any]) -> None:
    bench = Bench()
    node = ready(cls, bench.context, render_product_path=LIDAR)
    bench.lidar.see([INF] * 6)
    assert node.compute() is cls.exec_out
    assert points(node).shape == (0, 3)


@every_node
def test_a_render_product_selects_the_sensor(cls: type[Any]) -> None:
    bench = Bench()
    node = bench.sampled(cls, bench.context.render_product(RADAR, 1, 1))
    np.testing.assert_allclose(points(node), POINTS)


@every_node
def test_a_prim_that_is_neither_lidar_nor_radar_is_refused(cls: type[Any]) -> None:
    with pytest.raises(PrimError, match="not a lidar"):
        ready(cls, Bench().context, render_product_path="/robot")


@every_node
def test_in_a_graph_of_physics_steps_a_point_buffer_node_is_refused(cls: type[Any]) -> None:
    bench = Bench()
    bench.context.runs = "physics_step"
    with pytest.raises(ContextError, match="runs: tick"):
        ready(cls, bench.context, render_product_path=LIDAR)


SCENE = {
    "world.xml": """
        <mujoco><worldbody><geom type="plane" size="0 0 1"/>
          <geom type="box" size=".1 9 9" pos="3.1 0 0" rgba="1 1 1 1"/></worldbody></mujoco>
    """,
    "bot.yaml": """
        robot: bot
        extends: robots/dd100.yaml
        sensors:
          eye: {type: lidar, profile: lidar_3d_16, parent: base_link/chassis_link, position: [0.0, 0.0, 1.0]}
    """,
    "scene.yaml": """
        scene: scene
        world: world.xml
        physics: {tick_rate: 60, substeps: 4}
        robots: {dd100: {use: bot.yaml}}
        graphs: {points: {use: graph.yaml}}
    """,
}
GRAPH = """
    graph: points
    nodes:
      Tick: OnPlaybackTick
      Points: {type: TYPE, inputs: {renderProductPath: /dd100/chassis_link/eye/Lidar, FLAGS}}
      Time: IsaacReadSimulationTime
      Publish: {type: ROS2PublishPointCloud, inputs: {nodeNamespace: eye, outputIntensity: true, outputChannelId: true}}
    connections:
      - Tick.tick -> Points.exec
      - Points.exec -> Publish.execIn
      - Points.dataPtr -> Publish.dataPtr
      - Points.intensityPtr -> Publish.intensityPtr
      - Points.channelIdPtr -> Publish.channelIdPtr
      - Time.simulationTime -> Publish.timeStamp
    """


@pytest.mark.parametrize(
    ("type_name", "flags"),
    [
        ("IsaacCreateRTXLidarScanBuffer", "outputIntensity: true, outputChannelId: true"),
        ("OgnIsaacExtractRTXSensorPointCloud", ""),
    ],
)
def test_in_a_scene_the_buffers_are_published_as_a_point_cloud(play: Player, type_name: str, flags: str) -> None:
    graph = GRAPH.replace("TYPE", type_name).replace(", FLAGS", f", {flags}" if flags else "")
    playing = play.scene(SCENE | {"graph.yaml": graph}).tick(60)
    clouds = playing.published("/eye/point_cloud")
    assert len(clouds) == 11  # the first tick, then 10 Hz
    columns = {name: np.array(values) for name, values in read_points(clouds[-1]).items()}
    ahead = (np.abs(columns["y"]) < 1.0) & (columns["x"] > 1.0) & (columns["z"] > -0.9)
    np.testing.assert_allclose(columns["x"][ahead], 3.0, atol=0.15)
    np.testing.assert_allclose(columns["intensity"][ahead], 255.0, atol=0.01)
    assert set(columns["channel_id"].tolist()) == set(range(16))
    assert clouds[-1].header.stamp.sec == 1
