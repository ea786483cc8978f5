"""NavSatPublisher: each fix once, as sensor_msgs/NavSatFix defines it."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.navsat import NavSatStub
from graphengine.nodes.ros2.navsat import NavSatPublisher
from graphengine.testing import RecordingContext, check_node
from tests.nodes.harness import Player, dd100

CHASSIS = "/dd100/Geometry/base_link/chassis_link"
GRAPH = """
nodes:
  Tick: OnPlaybackTick
  Fix: {type: NavSatPublisher, inputs: {navSatPrim: /dd100/chassis_link/gps, frameId: gps, topicName: fix}}
connections: [Tick.tick -> Fix.execIn]
"""


def made() -> RecordingContext:
    context = RecordingContext()
    context.world.add_device(NavSatStub, "/Gps", horizontal_noise=2.0)
    return context


def test_check_node_accepts_the_navsat_publisher() -> None:
    check_node(NavSatPublisher, made, nav_sat_prim=["/Gps"])


@pytest.mark.parametrize(("fix", "status"), [("fix", 0), ("sbas_fix", 1), ("gbas_fix", 2)])
def test_a_fix_is_sent_once_with_its_stamp_status_and_covariance(play: Player, fix: str, status: int) -> None:
    world = dd100()
    sensor = world.add_device(NavSatStub, f"{CHASSIS}/gps", fix=fix, horizontal_noise=2.0, vertical_noise=3.0)
    sensor.measure(47.38, 8.54, 408.0, time=0.25, index=7)
    (message,) = play.graph(GRAPH, world).tick(3).published("/dd100_0000/fix")
    stamp = message.header.stamp
    assert (message.header.frame_id, stamp.sec, stamp.nanosec) == ("gps", 0, 250_000_000)
    assert (message.latitude, message.longitude, message.altitude) == (47.38, 8.54, 408.0)
    assert (message.status.status, message.status.service) == (status, 1)
    assert list(message.position_covariance) == [4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 9.0]
    assert message.position_covariance_type == 2


def test_without_a_fix_the_status_is_no_fix_and_the_covariance_unknown(play: Player) -> None:
    world = dd100()
    sensor = world.add_device(NavSatStub, f"{CHASSIS}/gps", fix="gbas_fix", horizontal_noise=2.0, vertical_noise=3.0)
    sensor.measure(math.nan, math.nan, math.nan)
    (message,) = play.graph(GRAPH, world).tick(3).published("/dd100_0000/fix")
    assert message.status.status == -1
    assert list(message.position_covariance) == [0.0] * 9
    assert message.position_covariance_type == 0
    assert all(map(math.isnan, (message.latitude, message.longitude, message.altitude)))


def test_a_robot_in_a_scene_publishes_fixes_with_the_shipped_graph(play: Player) -> None:
    playing = play.scene(
        {
            "bot.yaml": """
                robot: bot
                extends: robots/dd100.yaml
                sensors:
                  gps: {type: navsat, parent: base_link/chassis_link}
                graphs:
                  gps: {use: graphs/publishers/navsat.yaml, parameters: {sensor: base_link/chassis_link/gps, frame: gps}}
            """,
            "scene.yaml": """
                scene: scene
                world: worlds/flat_grid.xml
                spherical_coordinates: {latitude_deg: -33.86, longitude_deg: 151.21}
                robots: {dd100: {use: bot.yaml}}
            """,
        }
    ).tick(60)
    fixes = playing.published("/dd100_0000/fix")
    assert len(fixes) == 6  # at the first tick, then 5 Hz
    assert (fixes[-1].latitude, fixes[-1].longitude) == pytest.approx((-33.86, 151.21), abs=1e-5)
