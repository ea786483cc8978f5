"""Topics and services of a session."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.cli import main as graphrun
from graphengine.messages.messages import Clock, Odometry, Twist, Vector3
from graphengine.testing import session
from tests.api.conftest import Start
from tests.service_graph import SERVER, SET_BOOL

ODOM, CMD_VEL = "/dd100_0000/odom", "/dd100_0000/cmd_vel"
TRANSPORTS = ["memory", "dds"]


@pytest.fixture(params=TRANSPORTS)
def transport(request: pytest.FixtureRequest, domain_id: int, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    return str(request.param)


def test_a_robot_is_driven_and_its_odometry_read(transport: str) -> None:
    with session("dd100_flat", rays="mujoco", transport=transport) as sim:
        odom = sim.subscribe(ODOM, Odometry)
        sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        assert sim.run(5.0, until=lambda s: len(odom) > 20 and odom.messages[-1].twist.twist.linear.x > 0.2)
    assert odom.latest is not None
    assert odom.latest.twist.twist.linear.x > 0.2
    assert odom.dropped == 0


def test_names_of_a_robots_topics_are_relative_or_begin_with_a_slash(sim: ge.Session) -> None:
    robot = sim.robots["dd100"]
    heard = [robot.subscribe("odom"), robot.subscribe(ODOM)]
    drive = robot.publish(CMD_VEL, {"linear": {"x": 0.5}}, every=0.1)
    assert [subscription.topic for subscription in heard] == [ODOM, ODOM]
    assert drive.topic == CMD_VEL
    with pytest.raises(ge.UsageError, match=f"did you mean '{ODOM}'"):
        robot.subscribe("/odom")


def test_a_subscription_keeps_the_newest_messages(sim: ge.Session) -> None:
    clock = sim.subscribe("clock", Clock, keep=3)
    assert clock.latest is None
    sim.step(5)
    assert [message.clock.nanosec for message in clock] == [50_000_000, 66_666_666, 83_333_333]
    assert (len(clock), clock.dropped, clock.type) == (3, 2, "rosgraph_msgs/msg/Clock")
    assert repr(clock) == "<Subscription /clock (rosgraph_msgs/msg/Clock): 3 messages, 2 dropped>"
    clock.clear()
    assert (len(clock), clock.dropped, clock.latest) == (0, 0, None)
    sim.step()
    assert (len(clock), clock.dropped) == (1, 0)
    clock.close()
    sim.step()
    assert len(clock) == 1


def test_a_message_arrives_in_the_next_tick_and_then_each_period(sim: ge.Session) -> None:
    sim.step(2)
    heard = sim.subscribe(CMD_VEL)
    twist = Twist(Vector3(0.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    drive = sim.publish(CMD_VEL, twist, every=0.1)
    once = sim.publish(CMD_VEL, {"angular": {"z": 1}})
    ticks = []
    sim.run(0.5, until=lambda s: ticks.append(len(heard)) or False)  # type: ignore[func-returns-value]
    assert [ticks.index(number) for number in sorted(set(ticks))] == [0, 6, 12, 18, 24, 30]
    sim.reset("time")
    sim.step(13)
    assert len(heard) == 2 + 5 + 3
    drive.close()
    drive.close()
    sim.step(20)
    assert len(heard) == 10
    assert (repr(drive), repr(once)) == (
        f"<Publication {CMD_VEL} (geometry_msgs/msg/Twist), every 0.1 s>",
        f"<Publication {CMD_VEL} (geometry_msgs/msg/Twist), once>",
    )


def test_a_topic_that_no_graph_knows_needs_a_type(sim: ge.Session) -> None:
    heard = sim.subscribe("/chatter", type="std_msgs/String")
    sim.publish("/chatter", {"data": "hello"}, type="std_msgs/msg/String")
    assert [message.data for message in heard] == ["hello"]


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda sim: sim.subscribe("/odom"), f"no graph uses topic '/odom'\n  did you mean '{ODOM}'?"),
        (
            lambda sim: sim.subscribe(ODOM, Twist),
            f"{ODOM} has the type nav_msgs/msg/Odometry, not geometry_msgs/msg/Twist",
        ),
        (lambda sim: sim.subscribe(ODOM, keep=0), "keep: expected at least 1 message"),
        (lambda sim: sim.subscribe("/a", type="std_msgs/msg/Sting"), "std_msgs/msg/Sting"),
        (lambda sim: sim.subscribe("/a b", type="std_msgs/msg/String"), "has ' ' at character 3"),
        (lambda sim: sim.subscribe("/a", type=int), "got <class 'int'>"),
        (lambda sim: sim.publish("/cmd_vel", Twist(Vector3(0, 0, 0), Vector3(0, 0, 0))), f"did you mean '{CMD_VEL}'"),
        (lambda sim: sim.publish(CMD_VEL, {"linar": {}}), "has no field 'linar'; did you mean 'linear'?"),
        (lambda sim: sim.publish(CMD_VEL, {"linear": {"x": "fast"}}), "linear.x must be of type float64; got 'fast'"),
        (lambda sim: sim.publish(CMD_VEL, "fast"), "str is not a ROS message"),
        (lambda sim: sim.publish(CMD_VEL, {}, every=0.0), "every: expected a time above 0 s"),
        (lambda sim: sim.call("/light", {}), "no graph uses service '/light'"),
    ],
)
def test_what_cannot_be_is_told(sim: ge.Session, ask: Callable[[ge.Session], object], words: str) -> None:
    with pytest.raises(ge.GraphError) as caught:
        ask(sim)
    assert words in str(caught.value)


def test_a_service_of_a_graph_is_called(start: Start, transport: str) -> None:
    sim = start(SERVER, transport=transport)
    for wanted in (True, False):
        answer = sim.call("/light", {"data": wanted})
        assert (answer.success, answer.message) == (wanted, "done")
    assert sim.tick < 300


def test_a_service_that_nobody_offers_does_not_answer(start: Start) -> None:
    sim = start(SERVER)
    with pytest.raises(
        ge.TransportError, match=r"/dark: no response within 0\.5 s of simulation\n  there is no server of type"
    ):
        sim.call("/dark", {"data": True}, timeout=0.5, type=SET_BOOL)
    assert (sim.time, sim.state) == (0.5, "paused")


def test_what_a_user_sends_sets_and_asks_for_is_recorded_and_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "out.mcap"
    arguments: dict[str, Any] = {"rays": "mujoco", "seed": 3, "set": {"DiffController.maxAcceleration": 2.0}}
    with session("dd100_flat", record=path, **arguments) as sim:
        sim.publish(CMD_VEL, {"linear": {"x": 1.0}}, every=0.2)
        sim.run(0.5)
        sim.set("DiffController.maxLinearSpeed", 0.3)
        sim.set("PublishOdom.odomFrameId", "start")
        sim.push("dd100", force=(0.0, 5.0, 0.0), duration=0.1)
        sim.run(0.5)
        sim.set("*.maxLinearSpeed", 0.6)
        sim.run(0.5)
        assert sim.robots["dd100"].velocity.linear[0] == pytest.approx(0.6, abs=0.05)
    assert graphrun(["replay", str(path)]) == 0
    assert "90 ticks, 1.500 s" in capsys.readouterr().out


def test_a_latched_message_that_was_published_once_reaches_a_later_subscriber(start: Start) -> None:
    sim = start(
        """
nodes:
  Once: OnImpulseEvent
  Profile: {type: QoSProfile, inputs: {createProfile: Custom, depth: 1, durability: transientLocal}}
  Publish:
    type: ROS2Publisher
    inputs: {messagePackage: std_msgs, messageName: String, topicName: plan, data: lane 3}
connections:
  - Once.execOut -> Publish.execIn
  - Profile.qosProfile -> Publish.qosProfile
"""
    )
    sim.impulse("Once")
    sim.step(2)
    plan = sim.subscribe("/plan", "std_msgs/msg/String")
    sim.step()
    assert plan.latest is not None
    assert plan.latest.data == "lane 3"
