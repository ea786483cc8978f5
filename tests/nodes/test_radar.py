"""ROS2RtxRadarHelper: detections as PointCloud2 with the fields that are selected."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.radar import RadarStub
from graphengine.format.diagnostics import CheckError
from graphengine.nodes.ros2.radar import ROS2RtxRadarHelper
from graphengine.testing import RecordingContext
from tests.nodes.harness import HelperBench, Player, read_points, ready

RADAR = "/robot/Geometry/base_link/Radar"
POINTS = [[5.0, 1.0, 0.5], [0.25, -0.5, 0.0]]
ALL = {"output_radial_velocity_ms": True, "output_intensity": True, "output_timestamp": True}


class Bench(HelperBench):
    """A radar with two detections, and a helper on it."""

    def __init__(self, **inputs: Any) -> None:
        self.context = RecordingContext()
        self.context.world.add_robot("/robot")
        self.radar = self.context.world.add_device(RadarStub, RADAR, rate=20.0)
        self.node = ready(ROS2RtxRadarHelper, self.context, render_product_path=RADAR, **inputs)

    def published(self) -> Any:
        """The message of a tick with detections."""
        self.context.tick()
        self.radar.see(POINTS, [1.5, -2.0], [30.0, 90.0], time=2.25, index=3)
        (message,) = self.executed()
        return message


def test_without_metadata_a_detection_is_a_position_in_single_precision() -> None:
    message = Bench().published()
    assert (message.header.frame_id, message.height, message.width, message.point_step) == ("sim_radar", 1, 2, 12)
    assert read_points(message) == {"x": [5.0, 0.25], "y": [1.0, -0.5], "z": [0.5, 0.0]}


def test_selected_fields_follow_the_position_with_the_names_and_types_of_isaac_sim() -> None:
    message = Bench(**ALL).published()
    assert [(field.name, field.datatype, field.count) for field in message.fields[3:]] == [
        ("intensity", 7, 1),
        ("timestamp", 6, 2),
        ("radial_velocity_ms", 7, 1),
    ]
    columns = read_points(message)
    assert (columns["intensity"], columns["radial_velocity_ms"]) == ([30.0, 90.0], [1.5, -2.0])
    assert columns["timestamp"] == [(2_250_000_000, 0)] * 2
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (2, 250_000_000)


@pytest.mark.parametrize(
    ("selected", "field"),
    [
        ("output_radial_velocity_ms", "radial_velocity_ms"),
        ("output_intensity", "intensity"),
        ("output_timestamp", "timestamp"),
    ],
)
def test_each_input_selects_its_field_alone(selected: str, field: str) -> None:
    assert [found.name for found in Bench(**{selected: True}).published().fields[3:]] == [field]


def test_a_sample_without_detections_is_an_empty_cloud() -> None:
    bench = Bench(**ALL)
    bench.context.tick()
    bench.radar.see([])
    (message,) = bench.executed()
    assert (message.width, bytes(message.data)) == (0, b"")


def test_the_topic_is_isaac_sims_and_the_rate_the_radars() -> None:
    (claim,) = Bench().context.services.claims
    assert (claim.topic, claim.message_type, claim.rate) == ("/radar_point_cloud", "sensor_msgs/msg/PointCloud2", 20.0)


FILES = {
    "world.xml": """
        <mujoco><option gravity="0 0 0"/><worldbody>
          <body name="sheet" pos="5 0 1"><joint name="away" type="slide" axis="1 0 0"/>
            <geom type="box" size=".05 2 1" pos=".05 0 0" mass="10"/></body>
        </worldbody></mujoco>
    """,
    "tower.urdf": """<robot name="tower"><link name="base_link">
        <inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><geometry><box size=".2 .2 1"/></geometry></collision></link></robot>
    """,
    "tower.yaml": """
        robot: tower
        urdf: tower.urdf
        fixed_base: true
        namespaces: {eye: tower}
        sensors: {eye: {type: SENSOR, parent: base_link, position: [0, 0, 1]}}
        graphs: {radar: {use: graphs/publishers/radar.yaml, parameters: {radar: base_link/eye/CHILD}}}
    """,
    "scene.yaml": """
        scene: scene
        world: world.xml
        physics: {tick_rate: 60, substeps: 1}
        robots: {tower: {use: tower.yaml}}
    """,
}


def tower(sensor: str, child: str) -> dict[str, str]:
    """A scene with a tower that has a sensor, on which the shipped graph is used."""
    return FILES | {"tower.yaml": FILES["tower.yaml"].replace("SENSOR", sensor).replace("CHILD", child)}


def test_in_a_scene_a_sheet_that_moves_away_is_seen_with_its_distance_and_speed(play: Player) -> None:
    playing = play.scene(tower("radar, profile: radar_77ghz", "Radar"))
    world: Any = playing.session.services.world
    world.data.qvel[0] = 0.6
    playing.tick(60)
    clouds = playing.published("/tower/radar_point_cloud")
    assert len(clouds) == 21  # the first tick, then 20 Hz
    for cloud in (clouds[0], clouds[-1]):
        time = cloud.header.stamp.sec + cloud.header.stamp.nanosec * 1e-9
        columns = {name: np.array(values) for name, values in read_points(cloud).items()}
        assert columns["x"].mean() == pytest.approx(5.0 + 0.6 * time, abs=0.05)
        away = columns["x"] / np.sqrt(columns["x"] ** 2 + columns["y"] ** 2 + columns["z"] ** 2)
        assert (columns["radial_velocity_ms"] / away).mean() == pytest.approx(0.6, abs=0.02)
        assert columns["radial_velocity_ms"].std() == pytest.approx(0.03, abs=math.sqrt(2) * 0.01)


def test_a_lidar_is_refused_as_radar(play: Player) -> None:
    with pytest.raises(CheckError, match="is a lidar, not a radar"):
        play.scene(tower("lidar, profile: lidar_360", "Lidar"))
