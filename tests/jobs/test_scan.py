"""The lidar's messages: when they come, what a miss is, and that a point cloud is the same world."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.jobs.harness import Job, nanoseconds, tick_times

FACE = 2.0
"""m, how far ahead of the lidar the wall begins."""
LEFT = 1.5
"""m, how far to the left the other one does."""

WORLD = f"""<mujoco><worldbody>
  <geom name="floor" type="plane" size="0 0 1" friction="0.8"/>
  <body name="ahead" pos="{FACE + 0.5} 0 1"><geom type="box" size="0.5 1 1"/></body>
  <body name="beside" pos="0 {LEFT + 0.5} 1"><geom type="box" size="1 0.5 1"/></body>
</worldbody></mujoco>
"""
ROBOT = """robot: seeing
extends: robots/dd100.yaml
sensors:
  sim_lidar: {type: lidar, profile: profile, parent: base_link/chassis_link, position: [0.0, 0.0, 0.15]}
"""
SCENE = """scene: walls
world: world.xml
physics: {tick_rate: %s, substeps: %s}
settle: true
robots:
  dd100: {use: robot.yaml, position: [0.0, 0.0, 0.02]}
"""
PROFILE = """sensor: profile
lidar:
  rate: %s
  beams: {first_deg: -180.0, last_deg: 179.0, count: 360}
  near: 0.05
  far: 12.0
"""
TOPIC = "/dd100_0000/sim_lidar/scan"


def write(folder: Path, rate: float = 20.0, tick_rate: float = 60.0) -> Path:
    (folder / "world.xml").write_text(WORLD, encoding="utf-8")
    (folder / "robot.yaml").write_text(ROBOT, encoding="utf-8")
    (folder / "scene.yaml").write_text(SCENE % (tick_rate, max(1, round(240 / tick_rate))), encoding="utf-8")
    (folder / "sensors").mkdir()
    (folder / "sensors/profile.yaml").write_text(PROFILE % rate, encoding="utf-8")
    return folder / "scene.yaml"


# The law of samples


@pytest.mark.parametrize(
    ("rate", "tick_rate", "seconds"),
    [(20.0, 60, 6), (25.0, 60, 6), (7.0, 60, 6), (60.0, 60, 2), (9.7, 50, 10), (0.5, 60, 8)],
)
def test_sample_n_comes_at_the_first_tick_at_or_after_n_periods_with_the_stamp_of_that_tick(
    tmp_path: Path, rate: float, tick_rate: int, seconds: int
) -> None:
    with Job(write(tmp_path, rate, tick_rate)) as job:
        job.run(seconds)
        scans = job.heard(TOPIC)
    exact = Fraction(str(rate))
    samples = range(int(seconds * exact) + 1)
    ticks = {max(1, math.ceil(n / exact * tick_rate)) for n in samples}  # the first tick is at one period, not at 0
    stamps = [nanoseconds(scan.header.stamp) for scan in scans]
    assert stamps == pytest.approx(tick_times(sorted(ticks), tick_rate), rel=0, abs=1)
    assert [scan.scan_time for scan in scans] == pytest.approx([1.0 / rate] * len(ticks))


def test_the_mean_rate_is_exact() -> None:
    """At 20 Hz, 60 s hold 1200 samples and the one at the start, and the last is at 60 s to the nanosecond."""
    with Job("dd100_flat") as job:
        job.run(60.0)
        stamps = [nanoseconds(message.header.stamp) for message in job.heard(TOPIC)]
    assert len(stamps) == 1 + 60 * 20
    assert stamps[-1] == 60_000_000_000


def test_a_scan_is_not_cast_when_nobody_listens() -> None:
    with Job("dd100_warehouse", heard=False) as job:
        job.run(1.0)
        assert job.transport.raw(TOPIC) == []


# What a miss is


@pytest.mark.parametrize(("no_return", "miss"), [("inf", math.inf), ("max", 12.0), ("minus_one", -1.0)])
def test_a_beam_that_hits_nothing_reports_what_no_return_says(tmp_path: Path, no_return: str, miss: float) -> None:
    with Job(write(tmp_path), {"LidarHelper.noReturn": no_return}) as job:
        job.run(0.1)
        scan = job.newest(TOPIC)
    assert scan.ranges[180] == pytest.approx(FACE, abs=1e-3)  # 0 degrees, ahead
    assert scan.ranges[270] == pytest.approx(LEFT, abs=1e-3)  # 90 degrees, to the left
    assert scan.ranges[0] == miss  # behind
    assert scan.ranges[90] == miss  # to the right
    hit = (scan.ranges > scan.range_min) & (scan.ranges < scan.range_max)
    assert set(scan.ranges[~hit].tolist()) == {miss}


def test_inf_is_the_default(tmp_path: Path) -> None:
    with Job(write(tmp_path)) as job:
        job.run(0.1)
        assert math.isinf(job.newest(TOPIC).ranges[0])


# The point cloud


def points_of(cloud: Any) -> NDArray[np.float32]:
    """x, y, z by the message's own description of its bytes."""
    assert {(field.name, field.datatype, field.count) for field in cloud.fields} >= {(axis, 7, 1) for axis in "xyz"}
    rows = cloud.data.reshape(cloud.width, cloud.point_step)
    places = {field.name: field.offset for field in cloud.fields}
    columns = [rows[:, places[axis] : places[axis] + 4].copy().view("<f4")[:, 0] for axis in "xyz"]
    return np.stack(columns, axis=1)


def test_the_points_of_a_cloud_lie_where_the_scan_sees_something(tmp_path: Path) -> None:
    scene = write(tmp_path)
    with Job(scene) as job:
        job.run(0.1)
        scan = job.newest(TOPIC)
    with Job(scene, {"LidarHelper.type": "point_cloud"}) as job:
        job.run(0.1)
        assert job.types()[TOPIC] == "sensor_msgs/msg/PointCloud2"
        cloud = job.newest(TOPIC)

    assert (cloud.header.frame_id, cloud.header.stamp) == (scan.header.frame_id, scan.header.stamp)
    points = points_of(cloud)
    assert (cloud.height, cloud.width, cloud.row_step) == (1, len(points), cloud.point_step * len(points))
    assert not cloud.is_bigendian

    azimuth = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hit = np.isfinite(scan.ranges)
    ends = np.stack([scan.ranges[hit] * np.cos(azimuth[hit]), scan.ranges[hit] * np.sin(azimuth[hit])], axis=1)
    assert points[:, :2] == pytest.approx(ends, abs=1e-4)
    assert points[:, 2] == pytest.approx(np.zeros(len(points)), abs=1e-6)


def test_every_point_lies_on_a_wall(tmp_path: Path) -> None:
    with Job(write(tmp_path), {"LidarHelper.type": "point_cloud"}) as job:
        job.run(0.1)
        x, y, _ = points_of(job.newest(TOPIC)).T
    near = 2e-3
    on_ahead = (abs(x - FACE) < near) & (abs(y) <= 1.0 + near)
    on_beside = (abs(y - LEFT) < near) & (abs(x) <= 1.0 + near)
    sides = ((abs(abs(y) - 1.0) < near) & (x > FACE)) | ((abs(abs(x) - 1.0) < near) & (y > LEFT))
    assert (on_ahead | on_beside | sides).all()
    assert on_ahead.sum() > 40
    assert on_beside.sum() > 40


def test_the_robot_sees_the_wall_come_nearer_by_what_it_drives(tmp_path: Path) -> None:
    with Job(write(tmp_path)) as job:
        job.run(0.1)
        before = job.newest(TOPIC).ranges[180]
        job.drive("/dd100_0000/cmd_vel", 0.4, 0.0, 2.0)
        after, driven = job.newest(TOPIC), job.newest("/dd100_0000/odom").pose.pose.position.x
        assert nanoseconds(after.header.stamp) == nanoseconds(job.newest("/dd100_0000/odom").header.stamp)
    assert before - after.ranges[180] == pytest.approx(driven, abs=0.01)
