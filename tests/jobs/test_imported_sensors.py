"""Sensors that an import takes over from a description measure and publish what the description says."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from tests.bringup.robots.descriptions import SCAN, sensor, written
from tests.jobs.harness import Job, nanoseconds
from tests.physics.pictures.harness import needs_opengl

pytestmark = needs_opengl

WORLD = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="0 0 1"/>
  <geom name="ahead" type="box" size=".1 2 1" pos="2.1 0 0"/>
  <geom name="left" type="box" size="2 .1 1" pos="0 1.6 0"/>
</worldbody></mujoco>"""
SCENE = """scene: room
world: world.xml
physics: {tick_rate: 100, substeps: 2}
robots:
  bot: {use: robots/bot.yaml, position: [0, 0, 0.001], robot_state: true}
"""
PLUGIN = """<plugin name="lds" filename="libgazebo_ros_ray_sensor.so">
  <ros><remapping>~/out:=scan</remapping></ros><output_type>sensor_msgs/LaserScan</output_type>
  <frame_name>base_scan</frame_name></plugin>"""
NOISE = """<imu><linear_acceleration>
  <x><noise type="gaussian"><stddev>0.02</stddev><bias_mean>0.5</bias_mean></noise></x>
  <y><noise type="gaussian"><stddev>0.02</stddev></noise></y>
  <z><noise type="gaussian"><stddev>0.02</stddev></noise></z></linear_acceleration></imu>"""
CAMERA = """<camera><horizontal_fov>1.5707963267948966</horizontal_fov>
  <image><width>64</width><height>48</height></image><clip><near>0.05</near><far>20</far></clip></camera>
  <topic>front</topic><update_rate>10</update_rate>"""
RINGS = """<lidar><scan><horizontal><samples>90</samples><min_angle>-0.5</min_angle><max_angle>0.5</max_angle></horizontal>
  <vertical><samples>4</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></vertical></scan>
  <range><min>0.1</min><max>30</max></range></lidar><topic>velodyne</topic><update_rate>10</update_rate>"""
RANGE = """<pose>0.1 0 0 0 0 0.5</pose><ray><scan><horizontal><samples>1</samples><min_angle>-0.01</min_angle>
  <max_angle>0.01</max_angle></horizontal></scan><range><min>0.01</min><max>4</max></range></ray>
  <topic>range/front</topic><update_rate>5</update_rate>"""


@pytest.fixture(scope="module")
def heard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Job]:
    folder = written(
        tmp_path_factory.mktemp("room"),
        sensor("base_scan", "ray", f"<update_rate>5</update_rate><ray>{SCAN}</ray>{PLUGIN}", name="lds"),
        sensor("base_scan", "gpu_lidar", RINGS, name="puck"),
        sensor("imu_link", "imu", f"<update_rate>200</update_rate>{NOISE}", name="imu"),
        sensor("camera_link", "rgbd_camera", CAMERA, name="front"),
        sensor("camera_link", "gpu_lidar", RANGE, name="tof"),
        sensor("base_link", "contact", "<contact><collision>c</collision><topic>/bumper</topic></contact>"),
    )
    (folder / "world.xml").write_text(WORLD, encoding="utf-8")
    (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
    with Job(folder / "scene.yaml") as job:
        job.run(2.0)
        yield job


def test_a_scan_has_the_angles_and_distances_of_the_description(heard: Job) -> None:
    scan = heard.newest("/scan")
    stamps = [nanoseconds(message.header.stamp) for message in heard.heard("/scan")[1:]]
    assert set(np.diff(stamps)) == {200_000_000}
    assert scan.header.frame_id == "base_scan"
    assert (scan.angle_min, scan.angle_max) == pytest.approx((0.0, 6.28), abs=1e-6)
    assert (scan.range_min, scan.range_max) == pytest.approx((0.12, 3.5))
    assert len(scan.ranges) == 360
    assert scan.ranges[0] == pytest.approx(2.1, abs=0.008)  # from x = -0.1 to the wall at 2
    assert scan.ranges[90] == pytest.approx(1.5, abs=0.008)
    assert all(reading / 0.015 == pytest.approx(round(reading / 0.015), abs=1e-3) for reading in scan.ranges[:60])
    assert math.isinf(scan.ranges[180])


def test_an_imu_has_the_rate_noise_and_bias_of_the_description(heard: Job) -> None:
    readings = heard.heard("/imu")[200:]
    assert readings[0].header.frame_id == "imu_link"
    assert len(readings) == 200
    accelerations = np.array([[r.linear_acceleration.x, r.linear_acceleration.z] for r in readings])
    assert accelerations.mean(axis=0) == pytest.approx([0.5, 9.81], abs=0.01)
    assert accelerations.std(axis=0) == pytest.approx([0.02, 0.02], rel=0.25)


def test_rings_are_published_as_points(heard: Job) -> None:
    cloud = heard.newest("/velodyne/points")
    assert (cloud.width * cloud.height, cloud.header.frame_id) == (360, "base_scan")
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity", "ring", "time"]
    points = np.frombuffer(bytes(cloud.data), np.dtype("<f4, <f4, <f4, <f4, <u2, <f4"))
    assert points["f0"].max() == pytest.approx(2.1, abs=1e-3)
    assert set(points["f4"]) == {0, 1, 2, 3}


def test_a_range_sensor_stands_where_the_description_puts_it(heard: Job) -> None:
    reading = heard.newest("/range/front")
    assert (reading.field_of_view, reading.max_range) == pytest.approx((0.02, 4.0))
    assert reading.range == pytest.approx(
        1.8 / math.cos(0.5 - 0.01), abs=0.01
    )  # from x = 0.2, half a radian to the left
    (edge,) = (
        e for m in heard.heard("/tf_static") for e in m.transforms if e.child_frame_id == reading.header.frame_id
    )
    assert (edge.header.frame_id, edge.transform.translation.x) == ("camera_link", 0.1)
    assert edge.transform.rotation.z == pytest.approx(math.sin(0.25))


def test_a_camera_looks_ahead_in_its_optical_frame(heard: Job) -> None:
    info, depth = heard.newest("/front/camera_info"), heard.newest("/front/depth_image")
    assert (info.header.frame_id, info.width, info.height) == ("camera_optical_frame", 64, 48)
    assert info.k[0] == pytest.approx(32.0, rel=1e-6)
    distances = np.frombuffer(bytes(depth.data), np.float32).reshape(48, 64)
    assert distances[10, 32] == pytest.approx(1.9, abs=0.01)  # from x = 0.1 to the wall at 2
    assert heard.newest("/front/image").encoding == "rgb8"
    assert heard.heard("/front/points")


def test_a_contact_sensor_feels_the_floor(heard: Job) -> None:
    assert heard.newest("/bumper").data is True
