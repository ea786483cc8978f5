"""What only the transport in memory does: reading back, injecting, standing for readers."""

from __future__ import annotations

import pytest

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import MessageError, String, Twist, Vector3, decode, encode
from graphengine.ros.transports.memory.memory import MemoryTransport

STRING = "std_msgs/msg/String"


def test_written_messages_can_be_read_back_even_after_close() -> None:
    transport = MemoryTransport()
    writer = transport.writer("/chatter", STRING, QoS(depth=1))
    for value in "abc":
        writer.write(encode(String(value)))
    transport.close()
    assert transport.messages("/chatter") == [String("a"), String("b"), String("c")]
    assert transport.raw("/chatter") == [encode(String(value)) for value in "abc"]
    assert transport.messages("/never") == []


def test_wants_all_makes_every_writer_matched() -> None:
    writer = MemoryTransport(wants_all=True).writer("/chatter", STRING, QoS())
    assert writer.matched
    writer.close()
    assert not writer.matched


def test_an_injected_message_reaches_all_readers() -> None:
    transport = MemoryTransport()
    heard: list[bytes] = []
    transport.reader("/cmd_vel", "geometry_msgs/msg/Twist", QoS(), heard.append)
    twist = Twist(Vector3(1.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.5))
    transport.inject("/cmd_vel", twist)
    transport.inject("/cmd_vel", b"rubbish")
    assert decode(heard[0], "geometry_msgs/msg/Twist") == twist
    assert heard[1] == b"rubbish"


def test_injecting_into_a_topic_without_readers_is_an_error() -> None:
    transport = MemoryTransport()
    transport.reader("/cmd_vel", "geometry_msgs/msg/Twist", QoS(), lambda data: None)
    with pytest.raises(TransportError, match="/cmdvel has no readers\ntopics with readers: /cmd_vel"):
        transport.inject("/cmdvel", String(""))
    with pytest.raises(TransportError, match="/cmd_vel is read as geometry_msgs/msg/Twist, not as std_msgs/msg/String"):
        transport.inject("/cmd_vel", String(""))
    with pytest.raises(MessageError, match="is not a ROS message"):
        transport.inject("/cmd_vel", 3)


def test_late_joiners_get_all_kept_messages_in_the_order_of_writing() -> None:
    transport = MemoryTransport()
    keep = QoS(history="keepAll", durability="transientLocal")
    first, second = transport.writer("/map", STRING, keep), transport.writer("/map", STRING, keep)
    for number in range(20):
        (first if number % 2 else second).write(encode(String(str(number))))
    heard: list[bytes] = []
    transport.reader("/map", STRING, keep, heard.append)
    assert [decode(data, STRING).data for data in heard] == [str(number) for number in range(20)]


def test_after_a_restore_late_joiners_get_the_messages_kept_at_the_save() -> None:
    transport = MemoryTransport()
    latched = QoS(depth=1, durability="transientLocal")
    writer = transport.writer("/map", STRING, latched)
    writer.write(encode(String("a")))
    saved = transport.save()
    writer.write(encode(String("b")))
    transport.restore(saved)
    heard: list[bytes] = []
    transport.reader("/map", STRING, latched, heard.append)
    assert [decode(data, STRING).data for data in heard] == ["a"]
    assert transport.messages("/map") == [String("a"), String("b")]


def test_without_keeps_messages_are_delivered_but_cannot_be_read_back() -> None:
    transport = MemoryTransport(keeps=False)
    heard: list[bytes] = []
    transport.reader("/chatter", STRING, QoS(), heard.append)
    transport.writer("/chatter", STRING, QoS()).write(encode(String("a")))
    assert len(heard) == 1
    assert transport.raw("/chatter") == []
