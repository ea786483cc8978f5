"""Queues of impulses and custom events, and the mailboxes by which nodes see them."""

from __future__ import annotations

import pytest

from graphengine.format.errors import ContextError, UsageError
from graphengine.node.mailbox import IMPULSE, EventQueue, Mailbox, find_impulses


def test_each_mailbox_of_a_queue_takes_an_item_once_in_the_tick_after_it_was_posted() -> None:
    queue = EventQueue("event:bell")
    one, other = Mailbox(queue), Mailbox(queue)
    one.post("ring")
    assert list(one.take()) == []
    queue.freeze()
    assert [list(one.take()), list(one.take()), list(other.take())] == [["ring"], [], ["ring"]]
    queue.freeze()
    assert list(one.take()) == []


def test_an_impulse_goes_to_the_only_node_that_a_name_matches() -> None:
    queues = {f"{IMPULSE}/World/{graph}/Bell": EventQueue(graph) for graph in ("front", "back")}
    assert find_impulses(queues, "back/Bell") == ("/World/back/Bell", queues[f"{IMPULSE}/World/back/Bell"])
    with pytest.raises(
        UsageError, match=r"2 OnImpulseEvent nodes match 'Bell'\n  write one of: /World/front/Bell, /World/back/Bell"
    ):
        find_impulses(queues, "Bell")


def test_one_tick_takes_as_many_events_as_the_limit() -> None:
    queue = EventQueue("event:bell")
    for _ in range(EventQueue.LIMIT):
        queue.post()
    with pytest.raises(ContextError, match="more than 1000 events 'event:bell' in one tick"):
        queue.post()
    queue.freeze()
    assert len(queue.visible) == EventQueue.LIMIT
