"""The contract of a transport: bytes of one CDR message in, bytes out, topics by full name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from graphengine.context import QoS
from graphengine.ros.graph import Graph


class Writer(Protocol):
    """One topic to write encoded messages to."""

    @property
    def matched(self) -> bool:
        """Whether a reader is there now."""

    def write(self, data: bytes) -> None:
        """Send one CDR message, encapsulation header included; never blocks for longer than the reliability's 100 ms."""

    def close(self) -> None:
        """Leave the topic; safe to call twice."""


class Reader(Protocol):
    """One topic that is read; it delivers until it or the transport is closed."""

    def close(self) -> None:
        """Leave the topic; safe to call twice."""


class Transport(Protocol):
    """A way to the network, or to a test. Every writer and reader is owned, and closed, by it."""

    @property
    def description(self) -> str:
        """One line for people: what carries the messages, on which domain and discovery range."""

    @property
    def spin_time(self) -> float:
        """Seconds within which peers that are there have turned up, as a rule."""

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered, for who takes it; empty where it cannot be told."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """A writer on a topic such as `/dd100_0000/odom`; `message_type` as in `nav_msgs/msg/Odometry`."""

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> Reader:
        """A reader that calls `deliver` with each CDR message, from a thread of the transport or from its caller's."""

    def graph(self) -> Graph:
        """Who writes and reads which topic, this transport's own endpoints among them; listening begins with the first call.

        Raises:
            TransportError: the transport is closed.
        """

    def close(self) -> None:
        """Leave the network; safe to call twice."""
