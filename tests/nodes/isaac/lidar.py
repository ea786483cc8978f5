"""Cases of LaserScan."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphengine.testing import RecordingContext
from nodes.ros2.lidar import ROS2RtxLidarHelper
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import Case, differs, runs

SCAN = "isaacsim.ros2.bridge.ROS2PublishLaserScan"


def scan_of(
    angles: Any, ranges: Any = (0.05, 30.0), rate: float = 10.0, seen: Any = None, intensities: Any = 0.0
) -> Any:
    """The message of a lidar that sees that, or something everywhere."""
    context = RecordingContext()
    lidar = context.world.add_lidar("/Lidar", angles=angles, ranges=ranges, rate=rate)
    beams = round((angles[1] - angles[0]) / angles[2]) + 1
    lidar.see(np.ones(beams) if seen is None else seen, intensities)
    node = ready(ROS2RtxLidarHelper, context, render_product_path="/Lidar")
    return node.laser_scan(lidar.scan())


@runs(SCAN, "rotationRate 0 -> scan_time 0, time_increment 0")
def all_beams_are_of_one_instant_and_have_range_and_intensity(case: Case, play: Player) -> None:
    # A lidar here has a rate, so scan_time is not 0; what the case asserts holds at any rate.
    rays, (near, far) = 360, case["inputs"]["depthRange"]
    first, last = map(math.radians, case["inputs"]["azimuthRange"])
    scan = scan_of((first, last - math.radians(1.0), math.radians(1.0)), (near, float(far)))
    assert scan.time_increment == case["expect"]["time_increment"]
    assert len(scan.ranges) == len(scan.intensities) == rays


@differs(SCAN, "time_increment decreases with rotationRate")
def time_increments_at_two_rates(case: Case, play: Player) -> Any:
    return [scan_of((-1.0, 1.0, 0.5), rate=float(rate)).time_increment for rate in case["inputs"]["rotationRate"]]


@differs(SCAN, "GMO binning")
def a_miss_and_a_bright_hit(case: Case, play: Player) -> Any:
    scan = scan_of((0.0, 1.0, 1.0), seen=[math.inf, 1.0], intensities=[0.0, 255.0])
    return {"miss": float(scan.ranges[0]), "intensity of full brightness": float(scan.intensities[1])}


@differs(SCAN, "fields formula")
def fields_of_a_full_turn(case: Case, play: Player) -> Any:
    given = case["inputs"]
    step = math.radians(given["horizontalResolution"])
    first = math.radians(given["azimuthRange"][0])
    last = first + (given["n"] - 1) * step
    near, far = map(float, given["depthRange"])
    scan = scan_of((first, last, step), (near, far), float(given["rotationRate"]))
    assert len(scan.ranges) == given["n"]
    return {name: getattr(scan, name) for name in case["expect"]}
