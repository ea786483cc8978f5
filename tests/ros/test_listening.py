"""Queues and clocks of those who listen."""

from __future__ import annotations

import threading

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.cli_subscription import CLOCK, MessageQueue, SimulationClock
from graphengine.ros.transports.memory.memory import MemoryTransport


def test_messages_are_taken_oldest_first_with_their_arrival_time() -> None:
    times = iter((5, 7))
    inbox = MessageQueue(10, lambda: next(times))
    inbox.deliver(b"a")
    inbox.deliver(b"b")
    taken = [inbox.take(0.0), inbox.take(0.0)]
    assert [(arrival.data, arrival.time) for arrival in taken if arrival] == [(b"a", 5), (b"b", 7)]
    assert inbox.take(0.0) is None


def test_a_full_queue_drops_and_counts_the_oldest_messages() -> None:
    inbox = MessageQueue(2)
    for data in (b"a", b"b", b"c", b"d"):
        inbox.deliver(data)
    taken = [inbox.take(0.0), inbox.take(0.0)]
    assert [arrival.data for arrival in taken if arrival] == [b"c", b"d"]
    assert inbox.dropped == 2


def test_a_message_ends_the_wait_of_take() -> None:
    inbox = MessageQueue(2)
    thread = threading.Timer(0.01, inbox.deliver, [b"a"])
    thread.start()
    arrival = inbox.take(20.0)
    thread.join()
    assert arrival is not None


def test_simulation_time_is_zero_before_the_first_clock_message() -> None:
    transport = MemoryTransport()
    clock = SimulationClock(transport)
    assert clock() == 0
    assert not clock.wait(0.0)
    transport.inject(CLOCK, b"rubbish")
    assert not clock.wait(0.0)
    writer = transport.writer(CLOCK, "rosgraph_msgs/msg/Clock", QoS())
    writer.write(messages.encode(messages.Clock(messages.Time(3, 5))))
    assert clock.wait(0.0)
    assert clock() == 3_000_000_005
