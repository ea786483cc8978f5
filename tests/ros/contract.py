"""What the contract tests share: kinds of transports, a reader that keeps texts, and a second process."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TypeAlias

import pytest

from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, decode, encode
from graphengine.ros.foxglove.foxglove_transport import FoxgloveTransport
from graphengine.ros.transport import JoinOptions, Writer
from graphengine.ros.transports.composed import ComposedTransport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.rcl.rcl import RclTransport
from graphengine.ros.transports.rcl.rcl_profiles import is_installed
from tests.waiting import eventually

AnyTransport: TypeAlias = MemoryTransport | DdsTransport | RclTransport | ComposedTransport | FoxgloveTransport
Join: TypeAlias = Callable[..., AnyTransport]

STRING = "std_msgs/msg/String"
DEFAULT = QoS()

RCLPY = pytest.param("rclpy", marks=pytest.mark.ros)
# rclpy as it is without the types that these tests use, whose ends are on embedded DDS then.
COMPOSED = pytest.param("rclpy with dds", marks=pytest.mark.ros)
# The node called alice is of the first kind, all others are of the second.
MIXED = [pytest.param(kind, marks=pytest.mark.ros) for kind in ("dds to rclpy", "rclpy to dds")]
# The name of a transport that another package brings, if this variable has one: `-k NAME` runs the contract for it alone.
BROUGHT = os.environ.get("GRAPHENGINE_TRANSPORT", "").split()
# Another transport that Foxglove sees keeps the contract too.
SEEN = "dds seen by foxglove"
ALL = ["memory", "dds", SEEN, RCLPY, COMPOSED, *MIXED, *BROUGHT]
NETWORKED = ["dds", SEEN, RCLPY, COMPOSED, *MIXED, *BROUGHT]
# A writer of Fast DDS may lose the first large message to a reader of Cyclone DDS, and does not notice when that one goes:
# so it is between nodes of ROS 2 itself too.
FAITHFUL = ["dds", SEEN, RCLPY, COMPOSED, MIXED[0], *BROUGHT]


def composed(options: JoinOptions, *lacking: str) -> ComposedTransport:
    """rclpy and embedded DDS, both open, as if rclpy had no types of some packages."""

    def has(kind: str) -> bool:
        return kind.partition("/")[0] not in lacking and is_installed(kind)

    transport = ComposedTransport(RclTransport(options), has, lambda: DdsTransport(options, announces=False))
    transport.writer("/apart", f"{lacking[0]}/msg/Bool", QoS())
    return transport


class Inbox:
    """What a reader was given, as text."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, data: bytes) -> None:
        assert type(data) is bytes
        self.texts.append(decode(data, STRING).data)


def text(value: str) -> bytes:
    return encode(String(value))


def chatter(join: Join, qos: QoS = DEFAULT) -> tuple[Writer, Inbox]:
    """A writer of alice and what bob hears of it, once both ends know of each other."""
    inbox = Inbox()
    join("bob").reader("/chatter", STRING, qos, inbox)
    writer = join("alice").writer("/chatter", STRING, qos)
    connect(writer, inbox)
    return writer, inbox


def connect(writer: Writer, inbox: Inbox) -> None:
    """Wait until both ends know of each other: that one is matched does not tell that the other is."""
    assert eventually(lambda: writer.matched)
    assert eventually(lambda: inbox.texts, lambda: writer.write(text("probe")))
    writer.write(text("ready"))
    assert eventually(lambda: inbox.texts[-1] == "ready")
    inbox.texts.clear()
