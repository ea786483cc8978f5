"""Cases of LaserScan."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.lidar import LidarStub
from graphengine.nodes.ros2.laser_scan import ROS2PublishLaserScan
from graphengine.nodes.ros2.lidar import ROS2RtxLidarHelper
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import Case, differs, made, runs

SCAN = "isaacsim.ros2.bridge.ROS2PublishLaserScan"
RAYS = 360


def scan_of(case: Case, rays: int = RAYS, **inputs: Any) -> Any:
    """The message of a row of ranges, all of one metre."""
    row = {"linear_depth_data": np.ones(rays, np.float32), "num_rows": 1, "num_cols": rays}
    node = made(ROS2PublishLaserScan, case, **row, **inputs)
    node.setup(RecordingContext())
    return node.message()


@runs(SCAN, "rotationRate 0 -> scan_time 0, time_increment 0")
def without_a_rate_beams_are_of_one_instant(case: Case, play: Player) -> None:
    scan = scan_of(case, horizontal_fov=360.0)
    assert (scan.time_increment, scan.scan_time) == (case["expect"]["time_increment"], 0.0)
    assert len(scan.ranges) == len(scan.intensities) == RAYS


@runs(SCAN, "time_increment decreases with rotationRate")
def the_faster_it_turns_the_less_time_is_between_two_beams(case: Case, play: Player) -> None:
    slow, fast = (
        scan_of(case, horizontal_fov=360.0, rotation_rate=rate).time_increment
        for rate in case["inputs"]["rotationRate"]
    )
    assert slow > fast > 0.0


@runs(SCAN, "fields formula")
def fields_of_a_full_turn(case: Case, play: Player) -> None:
    scan, expected = scan_of(case, case["inputs"]["n"]), case["expect"]
    assert {name: getattr(scan, name) for name in expected} == pytest.approx(expected, abs=case["tolerance"])


@differs(SCAN, "GMO binning")
def a_miss_and_a_bright_hit(case: Case, play: Player) -> Any:
    context = RecordingContext()
    lidar = context.world.add_device(LidarStub, "/Lidar", angles=(0.0, 1.0, 1.0))
    lidar.see([math.inf, 1.0], [0.0, 255.0])
    scan = ready(ROS2RtxLidarHelper, context, render_product_path="/Lidar").laser_scan(lidar.scan())
    return {"miss": float(scan.ranges[0]), "intensity of full brightness": float(scan.intensities[1])}
