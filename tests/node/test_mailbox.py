"""Queues of impulses and custom events, and the mailboxes by which nodes see them."""

from __future__ import annotations

from graphengine.node.mailbox import EventQueue, Mailbox


def test_each_mailbox_of_a_queue_takes_an_item_once_in_the_tick_after_it_was_posted() -> None:
    queue = EventQueue("event:bell")
    one, other = Mailbox(queue), Mailbox(queue)
    one.post("ring")
    assert list(one.take()) == []
    queue.freeze()
    assert [list(one.take()), list(one.take()), list(other.take())] == [["ring"], [], ["ring"]]
    queue.freeze()
    assert list(one.take()) == []
