"""A second process of the tests: joins the domain that its environment names and plays one part until its input ends."""

from __future__ import annotations

import os
import random
import sys
import threading
import time

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, Twist, Vector3, decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport

STRING = "std_msgs/msg/String"


def echo(transport: DdsTransport) -> None:
    """Send back what comes, until the input ends."""
    pong = transport.writer("/pong", STRING, QoS())
    transport.reader("/ping", STRING, QoS(), pong.write)
    sys.stdin.read()


def ask(transport: DdsTransport) -> None:
    """Call a service for each message that comes, until the input ends."""
    client = transport.client("/trigger", "std_srvs/srv/Trigger", QoS(), lambda number, data: None)
    request = encode(DEFINITIONS.initial("std_srvs/srv/Trigger_Request"))

    def call(data: bytes) -> None:
        client.call(request)

    transport.reader("/ping", STRING, QoS(), call)
    sys.stdin.read()


def flood(transport: DdsTransport) -> None:
    """Write as fast as it goes, until the input ends."""
    reading = threading.Thread(target=sys.stdin.read, daemon=True)
    reading.start()
    writer = transport.writer("/crowd", STRING, QoS())
    while reading.is_alive():
        for _ in range(20):
            writer.write(encode(String("flood")))
        time.sleep(0.0005)


def crowd(transport: DdsTransport) -> None:
    """Write to the topic that it reads, while another process writes to it too, until both were heard often."""
    heard = {b"crowd": 0, b"flood": 0}

    def count(data: bytes) -> None:
        heard[data[8:13]] += 1

    transport.reader("/crowd", STRING, QoS(), count)
    writer = transport.writer("/crowd", STRING, QoS())
    while min(heard.values()) < 3000:
        for _ in range(20):
            writer.write(encode(String("crowd")))
        time.sleep(0.0005)


def control(transport: DdsTransport) -> None:
    """Command a velocity ten times in a second of /clock, at a random time after its /clock, until the input ends."""
    slow, due = float(os.environ["SLOW"]), 100_000_000
    writer = transport.writer("/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist", QoS())

    def answer(data: bytes) -> None:
        nonlocal due
        clock = decode(data, "rosgraph_msgs/msg/Clock").clock
        now = clock.sec * 1_000_000_000 + clock.nanosec
        if now >= due:
            due = now // 100_000_000 * 100_000_000 + 100_000_000
            time.sleep(random.uniform(0.0, slow))
            writer.write(encode(Twist(Vector3(0.5 + now / 1e10, 0.0, 0.0), Vector3(0.0, 0.0, now / 1e10))))

    transport.reader("/clock", "rosgraph_msgs/msg/Clock", QoS(depth=1, reliability="bestEffort"), answer)
    sys.stdin.read()


if __name__ == "__main__":
    part = {"echo": echo, "ask": ask, "flood": flood, "crowd": crowd, "control": control}[sys.argv[1]]
    joined = DdsTransport(JoinOptions(Domain.from_environment(os.environ), f"peer_{sys.argv[1]}"))
    part(joined)
    joined.close()
