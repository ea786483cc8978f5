"""`graphrun teleop`: keys of a terminal that become velocities, and the terminal afterwards."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import signal
import subprocess
import termios
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from graphengine.cli.teleop import Stick, only_topic, type_of
from graphengine.format.errors import UsageError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network_graph import Endpoint, NetworkGraph
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import ROOT, Graphrun, command, environment
from tests.waiting import PATIENCE

TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


class Robot:
    """A peer that takes velocities."""

    def __init__(self, domain: Domain) -> None:
        self.transport = DdsTransport(JoinOptions(domain, "robot"))
        self.heard: list[Any] = []

    def listen(self, topic: str, message_type: str) -> None:
        deliver = self.heard.append
        self.transport.reader(topic, message_type, QoS(), lambda data: deliver(messages.decode(data, message_type)))

    def velocity(self) -> tuple[float, float]:
        """Of the newest command."""
        newest = getattr(self.heard[-1], "twist", self.heard[-1])
        return newest.linear.x, newest.angular.z


class Driver:
    """A terminal with `graphrun teleop` in it."""

    def __init__(self, domain: Domain, *arguments: str) -> None:
        self.said = ""
        self.master, self.terminal = pty.openpty()
        self.before = termios.tcgetattr(self.terminal)
        self.process = subprocess.Popen(
            command("teleop", "--transport", "dds", "--spin-time", "20", *arguments),
            cwd=ROOT,
            env=environment({"ROS_DOMAIN_ID": str(domain.id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}),
            stdin=self.terminal,
            stdout=self.terminal,
            stderr=self.terminal,
        )

    def press(self, keys: str) -> None:
        os.write(self.master, keys.encode())

    def wait(self, condition: Callable[[], bool], keys: str = "") -> bool:
        """Until it is so, pressing keys meanwhile."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            while select.select([self.master], [], [], 0.02)[0]:
                self.said += os.read(self.master, 65536).decode()
            if condition():
                return True
            self.press(keys)
        return False

    def end(self) -> int:
        self.wait(lambda: self.process.poll() is not None)
        return self.process.wait(PATIENCE)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.master)
        os.close(self.terminal)


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "LOCALHOST")


@pytest.fixture
def robot(domain: Domain) -> Iterator[Robot]:
    made = Robot(domain)
    with contextlib.closing(made.transport):
        yield made


@contextlib.contextmanager
def driver(domain: Domain, *arguments: str) -> Iterator[Driver]:
    with contextlib.closing(Driver(domain, *arguments)) as made:
        assert made.wait(lambda: "keys give" in made.said), made.said
        yield made


def test_keys_drive_the_robot_and_a_release_stops_it(domain: Domain, robot: Robot) -> None:
    robot.listen("/robot/cmd_vel", TWIST)
    with driver(domain, "/robot/cmd_vel", "--hold", "0.2") as hands:
        assert f"/robot/cmd_vel [{TWIST}]" in hands.said
        assert hands.wait(lambda: bool(robot.heard) and robot.velocity() == (0.5, 0.0), "w"), robot.heard[-3:]
        assert hands.wait(lambda: robot.velocity() == (0.0, 0.0))
        assert hands.wait(lambda: robot.velocity() == (-0.5, 1.0), "\x1b[B\x1b[D")
        assert hands.wait(lambda: "-0.50 m/s   1.00 rad/s" in hands.said), hands.said
        assert hands.wait(lambda: robot.velocity() == (0.0, 0.0), " ")
        hands.press("q")
        assert hands.end() == 0
        assert termios.tcgetattr(hands.terminal) == hands.before


def test_subscribers_of_stamped_velocities_get_stamped_velocities(domain: Domain, robot: Robot) -> None:
    robot.listen("/cmd_vel", STAMPED)
    with driver(domain, "/cmd_vel", "--frame-id", "base_link") as hands:
        begun = time.time()
        assert hands.wait(lambda: bool(robot.heard) and robot.velocity() == (0.0, -1.0), "d")
        header = robot.heard[-1].header
        assert header.frame_id == "base_link"
        assert begun - 1.0 < header.stamp.sec <= time.time()
        hands.press("\x03")
        assert hands.end() == 0
        assert termios.tcgetattr(hands.terminal) == hands.before
        assert hands.wait(lambda: robot.velocity() == (0.0, 0.0))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_robot_and_restores_the_terminal(
    domain: Domain, robot: Robot, number: signal.Signals
) -> None:
    robot.listen("/cmd_vel", TWIST)
    with driver(domain, "/cmd_vel", "--hold", "60") as hands:
        assert hands.wait(lambda: bool(robot.heard) and robot.velocity() == (0.5, 0.0), "w")
        hands.process.send_signal(number)
        assert hands.end() == 0
        assert hands.wait(lambda: robot.velocity() == (0.0, 0.0))
        assert termios.tcgetattr(hands.terminal) == hands.before


def test_a_key_press_acts_for_the_hold_time_in_each_direction() -> None:
    stick = Stick(hold=0.5, speed=0.4, turn=2.0)
    stick.press("w", 0.0)
    assert stick.command(0.49) == (0.4, 0.0)
    stick.press("left", 0.3)
    assert stick.command(0.49) == (0.4, 2.0)
    assert stick.command(0.51) == (0.0, 2.0)
    assert stick.command(0.81) == (0.0, 0.0)


def test_plus_and_minus_change_the_speeds() -> None:
    stick = Stick(hold=0.5, speed=0.4, turn=2.0)
    stick.press("+", 0.0)
    stick.press("up", 0.0)
    assert stick.command(0.1)[0] == pytest.approx(0.44)
    assert stick.turn == pytest.approx(2.2)
    stick.press("-", 0.0)
    assert stick.command(0.1)[0] == pytest.approx(0.4)


def test_space_stops_at_once_and_unknown_keys_have_no_effect() -> None:
    stick = Stick(hold=0.5, speed=0.4, turn=2.0)
    stick.press("s", 0.0)
    stick.press("x", 0.0)
    stick.press("", 0.0)
    assert stick.command(0.1) == (-0.4, 0.0)
    stick.press(" ", 0.1)
    assert stick.command(0.2) == (0.0, 0.0)


def reader(topic: str, message_type: str) -> Endpoint:
    return Endpoint(os.urandom(16), "subscribe", topic, message_type, QoS())


def test_the_only_velocity_topic_is_the_default() -> None:
    others = [reader("/chatter", "std_msgs/msg/String"), Endpoint(b"", "publish", "/b/cmd_vel", TWIST, QoS())]
    assert only_topic(NetworkGraph([reader("/a/cmd_vel", TWIST), *others])) == "/a/cmd_vel"
    assert only_topic(NetworkGraph(others)) == "/cmd_vel"
    two = [reader("/a/cmd_vel", TWIST), reader("/b/cmd_vel", STAMPED)]
    with pytest.raises(
        UsageError, match=r"several topics have subscribers .*\n  give one as TOPIC: /a/cmd_vel, /b/cmd_vel"
    ):
        only_topic(NetworkGraph(two))


@pytest.mark.parametrize(
    ("read", "expected"), [([], TWIST), ([TWIST], TWIST), ([STAMPED], STAMPED), ([STAMPED, TWIST], TWIST)]
)
def test_teleop_publishes_the_type_of_the_subscribers(read: list[str], expected: str) -> None:
    ends = [reader("/cmd_vel", message_type) for message_type in read]
    assert type_of("/cmd_vel", NetworkGraph([*ends, reader("/other", STAMPED)])) == expected


def test_without_a_terminal_teleop_is_refused(graphrun: Graphrun) -> None:
    result = graphrun("teleop", "--transport", "dds", code=2, out="")
    assert result.err.startswith("graphrun teleop: keys are read from a terminal, but the standard input is not one\n")
