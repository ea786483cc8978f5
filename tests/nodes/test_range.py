"""RangePublisher: each sample once, as sensor_msgs/Range defines it."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.range import RangeSensorStub
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import ContextError
from graphengine.nodes.ros2.range import RangePublisher
from graphengine.testing import RecordingContext, check_node
from tests.nodes.harness import Player, dd100, ready

CHASSIS = "/dd100/Geometry/base_link/chassis_link"
GRAPH = """
runs: RUNS
nodes:
  Tick: EVENT
  Sonar: {type: RangePublisher, inputs: {rangePrim: /dd100/chassis_link/sonar, frameId: sonar, topicName: sonar}}
connections: [Tick.OUT -> Sonar.execIn]
"""
ON_TICKS = GRAPH.replace("RUNS", "tick").replace("EVENT", "OnPlaybackTick").replace("OUT", "tick")
ON_STEPS = GRAPH.replace("RUNS", "physics_step").replace("EVENT", "OnPhysicsStep").replace("OUT", "step")
FACTS = {"rate": 20.0, "field_of_view": 0.5, "ranges": (0.1, 3.0), "noise_std": 0.01}


def made() -> RecordingContext:
    context = RecordingContext()
    context.world.add_device(RangeSensorStub, "/Sonar", **FACTS)
    return context


def test_check_node_accepts_the_range_publisher() -> None:
    check_node(RangePublisher, made, range_prim=["/Sonar"])


@pytest.mark.parametrize("distance", [1.25, math.inf, -math.inf])
@pytest.mark.parametrize(("radiation", "number"), [("ultrasound", 0), ("infrared", 1)])
def test_a_sample_is_sent_once_with_its_stamp_and_the_figures_of_the_sensor(
    play: Player, distance: float, radiation: str, number: int
) -> None:
    world = dd100()
    sensor = world.add_device(RangeSensorStub, f"{CHASSIS}/sonar", radiation_type=radiation, **FACTS)
    sensor.measure(distance, time=0.25, index=7)
    playing = play.graph(ON_TICKS, world).tick(3)
    (message,) = playing.published("/dd100_0000/sonar")
    assert (message.header.frame_id, message.header.stamp.sec, message.header.stamp.nanosec) == (
        "sonar",
        0,
        250_000_000,
    )
    assert (message.radiation_type, message.range) == (number, distance)
    assert (message.field_of_view, message.min_range, message.max_range) == pytest.approx((0.5, 0.1, 3.0))
    assert message.variance == pytest.approx(0.01**2)


def test_nothing_is_sent_without_a_sample(play: Player) -> None:
    world = dd100()
    world.add_device(RangeSensorStub, f"{CHASSIS}/sonar")
    playing = play.graph(ON_TICKS, world).tick(3)
    assert playing.published("/dd100_0000/sonar") == []


def test_the_rate_of_the_topic_is_the_sensors_but_at_most_the_tick_rate() -> None:
    for rate, expected in ((20.0, 20.0), (100.0, 60.0)):
        context = RecordingContext()
        context.world.add_device(RangeSensorStub, "/Sonar", rate=rate)
        ready(RangePublisher, context, range_prim=["/Sonar"])
        assert [claim.rate for claim in context.services.claims] == [pytest.approx(expected)]


def test_the_error_of_a_prim_of_another_kind_lists_the_range_sensors() -> None:
    context = made()
    context.world.stage.add("/Wall", "body")
    with pytest.raises(ContextError, match=r"'/Wall' is a body, not a range sensor") as caught:
        ready(RangePublisher, context, range_prim=["/Wall"])
    assert caught.value.help == ("prims of this kind: /Sonar",)


def test_in_a_graph_of_physics_steps_the_range_publisher_is_refused(play: Player) -> None:
    world = dd100()
    world.add_device(RangeSensorStub, f"{CHASSIS}/sonar")
    with pytest.raises(
        CheckError, match="a range sensor is sampled once a tick, but this graph runs at every physics step"
    ):
        play.graph(ON_STEPS, world)


def test_a_robot_in_a_scene_measures_the_wall_ahead(play: Player) -> None:
    playing = play.scene(
        {
            "world.xml": """
                <mujoco><worldbody><geom type="plane" size="0 0 1"/>
                  <geom type="box" size=".1 9 9" pos="2.1 0 0"/></worldbody></mujoco>
            """,
            "bot.yaml": """
                robot: bot
                extends: robots/dd100.yaml
                sensors:
                  sonar: {type: range, profile: hc_sr04, parent: base_link/chassis_link, position: [0.0, 0.0, 0.5]}
            """,
            "graph.yaml": "format: 1\ngraph: graph\n" + ON_TICKS,
            "scene.yaml": """
                scene: scene
                world: world.xml
                physics: {tick_rate: 60, substeps: 4}
                settle: true
                robots: {dd100: {use: bot.yaml}}
                graphs: {sonar: {use: graph.yaml}}
            """,
        }
    ).tick(30)
    ranges = [message.range for message in playing.published("/dd100_0000/sonar")]
    assert ranges == pytest.approx(
        [2.0] * 9, abs=5 * 0.003 + 0.005
    )  # the first tick, then 16 Hz; the robot settles a bit
