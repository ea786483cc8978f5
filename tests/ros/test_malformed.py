"""Bytes that are no message of the topic's type: dropped, counted, told once, whoever sends them."""

from __future__ import annotations

import ctypes
import logging
import os
import platform
import socket
import struct
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros.network import LiveNetwork
from graphengine.ros.qos_diagnostics import Watch
from graphengine.ros.transports.dds import cyclone_log
from graphengine.ros.transports.dds.cyclone_log import CycloneLog
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.messages.test_messages import random_message
from tests.ros.conftest import StartPeer
from tests.ros.contract import STRING, AnyTransport, Inbox, text
from tests.waiting import eventually

TYPES = [STRING, "geometry_msgs/msg/Twist", "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage"]
TYPES += ["sensor_msgs/msg/PointCloud2", "visualization_msgs/msg/InteractiveMarker"]
HUGE = st.sampled_from([b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\1\0"])
PORTS = 7400
"""Of domain 0; each domain has 250, in which unicast data of participant n is at 11 + 2 n (DDSI-RTPS 9.6.1)."""


@st.composite
def mutilated(draw: st.DrawFn) -> tuple[str, bytes]:
    """A type, and a message of it of which some bytes are others, missing or too many, or say that there are 4e9 elements."""
    message_type = draw(st.sampled_from(TYPES))
    data = bytearray(messages.encode(random_message(message_type, np.random.default_rng(draw(st.integers(0, 5))))))
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(data)))
        match draw(st.sampled_from(["other", "length", "cut", "more"])):
            case "other":
                data[place : place + 1] = draw(st.binary(min_size=1, max_size=1))
            case "length":
                data[place & -4 : (place & -4) + 4] = draw(HUGE)
            case "cut":
                del data[place:]
            case _:
                data[place:place] = draw(st.binary(max_size=9))
    return message_type, bytes(data)


@given(mutilated())
def test_decoding_any_bytes_raises_no_unexpected_error_and_takes_little_memory(given: tuple[str, bytes]) -> None:
    message_type, data = given
    tracemalloc.start()
    try:
        messages.decode(data, message_type)
    except TransportError:
        pass
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    # Objects of Python for each element of a message; the code that decodes a type is made once, of less than a megabyte.
    assert peak < 1_000_000 + 1000 * len(data)


@given(st.lists(mutilated(), max_size=5))
def test_a_subscription_survives_malformed_messages(arriving: list[tuple[str, bytes]]) -> None:
    said: list[str] = []
    network = LiveNetwork(lambda domain: MemoryTransport(), 0, said.append)
    claim = EndpointClaim("/node", "graph", "/chatter", STRING, "subscribe", QoS())
    subscription = network.subscription(claim)
    for _, data in arriving:
        subscription.deliver(data)
    network.freeze()
    taken = subscription.take()
    assert len(taken) + subscription.malformed == len(arriving)
    assert network.malformed == ({"/chatter": subscription.malformed} if subscription.malformed else {})
    assert len(said) == min(subscription.malformed, 1)


class Hostile(MemoryTransport):
    malformed = {"/chatter": 3}  # noqa: RUF012


def test_messages_that_the_transport_dropped_are_reported_once() -> None:
    said: list[str] = []
    now = [0.0]
    watch = Watch(Hostile(), list, said.append, lambda: now[0])
    for now[0] in (0.0, 10.0):
        watch.look()
        watch.finish()
    assert said == ["/chatter: a peer sends messages that do not fit the topic's type; they are dropped"]
    assert LiveNetwork(lambda domain: Hostile(), 0, said.append).malformed == {"/chatter": 3}


class Foreign(MemoryTransport):
    malformed = {"/reset": 3, "/chatter": 1}  # noqa: RUF012
    foreign_services = {"/reset": "/reset: a client on another RMW"}  # noqa: RUF012


def test_an_incompatible_peer_is_reported_once_without_a_report_of_malformed_messages() -> None:
    said: list[str] = []
    network = LiveNetwork(lambda domain: Foreign(), 0, said.append)
    for _ in range(100):
        network.freeze()
    network.close()
    assert said == [
        "/reset: a client on another RMW",
        "/chatter: a peer sends messages that do not fit the topic's type; they are dropped",
    ]


def forged(gid: bytes, number: int, data: bytes) -> bytes:
    """An RTPS packet with one message of a writer that did not write it (DDSI-RTPS 9.4)."""
    header = b"RTPS\2\1\1\x10" + gid[:12]
    content = struct.pack("<HH4s4siI", 0, 16, bytes(4), gid[12:], 0, number) + data
    return header + struct.pack("<BBH", 0x15, 0x05, len(content)) + content


def send_forged(domain_id: int, gid: bytes, data: bytes) -> None:
    """Send a message as if it were the first of a writer, to whoever is on this host in a domain."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for participant in range(10):
            sender.sendto(forged(gid, 1, data), ("127.0.0.1", PORTS + 250 * domain_id + 11 + 2 * participant))


@pytest.mark.parametrize("kind", ["dds"])
@pytest.mark.parametrize("data", [b"\0\1\0\0" + body for body in (b"rubbish!", b"\xff" * 4 + bytes(16), bytes(1))])
def test_after_a_forged_message_later_messages_arrive(
    alice: AnyTransport, domain_id: int, start_peer: StartPeer, data: bytes, capfd: pytest.CaptureFixture[str]
) -> None:
    inbox = Inbox()
    alice.reader("/pong", STRING, QoS(), inbox)
    ping = alice.writer("/ping", STRING, QoS())
    start_peer("echo")
    assert eventually(lambda: ping.matched and alice.graph().publishers("/pong"))
    (pong,) = alice.graph().publishers("/pong")
    assert eventually(lambda: "/pong" in alice.malformed, lambda: send_forged(domain_id, pong.gid, data))
    assert inbox.texts == []
    assert eventually(lambda: "hello" in inbox.texts, lambda: ping.write(text("hello")))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("kind", [pytest.param("rclpy to dds", marks=pytest.mark.ros)])
def test_malformed_messages_of_a_ros_node_are_dropped_and_counted(alice: AnyTransport, bob: AnyTransport) -> None:
    inbox = Inbox()
    bob.reader("/chatter", STRING, QoS(), inbox)
    writer = alice.writer("/chatter", STRING, QoS())
    assert eventually(lambda: writer.matched)

    def dropped() -> bool:
        writer.write(b"\0\1\0\0\xff\xff\xff\xffrubbish!")
        writer.write(text("good"))
        return "/chatter" in bob.malformed and "good" in inbox.texts

    assert eventually(dropped)
    assert set(inbox.texts) == {"good"}


@pytest.fixture
def log() -> CycloneLog:
    if platform.libc_ver()[0] != "glibc":
        pytest.skip("complaints go to the terminal")
    return CycloneLog()


def complain(log: CycloneLog, *lines: str) -> None:
    """What Cyclone does."""
    library = ctypes.CDLL(None)
    with log.capture():
        stream = ctypes.c_void_p(ctypes.c_void_p.in_dll(library, "stderr").value)
    for line in lines:
        library.fputs(line.encode(), stream)
    library.fflush(stream)


def test_log_lines_of_cyclone_are_counted_or_logged_once_for_each_kind(
    log: CycloneLog, caplog: pytest.LogCaptureFixture
) -> None:
    lost = "[7] recv: data(application, vendor 1.15): 10f:2:3 #1: deserialization rt/j/String_ failed (x)\n"
    with caplog.at_level(logging.WARNING):
        complain(log, *(f"17952793.3115 [51]       recv: send to {port} failed\n" for port in (7410, 7411)))
        complain(log, f"17952793.4 {lost}1")
        assert log.malformed(7) == {"/j": 1}
        complain(log, f"7952793.5 {lost}")
        assert log.malformed(7) == {"/j": 2}
    assert log.malformed(51) == {}
    assert [record.getMessage() for record in caplog.records] == ["Cyclone DDS: send to 7410 failed"]
    log.forget(7)
    assert log.malformed(7) == {}


def test_forged_packets_are_logged_by_kind_and_then_counted_once_a_minute(
    log: CycloneLog, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 0.0
    monkeypatch.setattr("graphengine.ros.transports.dds.cyclone_log.time.monotonic", lambda: now)
    packet = "malformed packet received from vendor {0} state parse:{1}a{1} <{2} {1}>"
    packets = [packet.format(n, c, c * n) for n in range(40) for c in "abf"]
    words = [f"complaint {'xyz'[n % 3]}{'ghijklmno'[n // 9 % 9]}{'ghijklmno'[n % 9]}" for n in range(81)]
    with caplog.at_level(logging.WARNING):
        now = 100.0
        complain(log, *(f"1.5 [7] recv: {line}\n" for line in packets))
        log.malformed(7)
        assert len(caplog.records) == 1
        for moment in (200.0, 201.0, 270.0):
            now = moment
            complain(log, *(f"1.5 [7] recv: \x1b[31m{word}\n" for word in words))
            log.malformed(7)
    said = [record.getMessage() for record in caplog.records]
    assert len(said) == cyclone_log.MAX_KINDS + 2
    assert said[-2:] == [
        "Cyclone DDS: 62 further log lines are not shown",
        "Cyclone DDS: 124 further log lines are not shown",
    ]
    assert all(text.isprintable() for text in said)


def test_log_lines_that_were_read_are_discarded(log: CycloneLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cyclone_log, "_MAX_SIZE", 1000)
    for number in range(1, 50):
        complain(log, "1.5 [7] recv: deserialization rt/j/String_ failed (x)\n")
        assert log.malformed(7) == {"/j": number}
        assert os.fstat(log._file or 0).st_size <= 1000
