"""Queues that carry impulses and custom events from one tick to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.errors import ContextError, UsageError
from graphengine.format.stateful import Stateful
from graphengine.format.wording import did_you_mean, listing

IMPULSE = "impulse:"
"""Prefix of the names of impulse queues; the name is this prefix, followed by the prim path of the node."""


class EventQueue(Stateful):
    """A queue of events. An event that is posted in one tick is visible in the next; at most 1000 can be posted in a tick."""

    LIMIT = 1000
    """Maximum number of events of one name in a tick."""
    kept = ("_posted", "ticks", "visible")

    def __init__(self, name: str) -> None:
        self.name = name
        self.visible: Sequence[Any] = ()
        """Items that were posted during the previous tick; they are discarded at the end of this tick."""
        self.ticks = 0
        self._posted: list[Any] = []

    def post(self, item: Any = None) -> None:
        """Queue an item for the next tick.

        Raises:
            ContextError: the queue is full.
        """
        if len(self._posted) >= self.LIMIT:
            text = f"more than {self.LIMIT} events {self.name!r} in one tick"
            raise ContextError(text, self.name, "the event may be triggering itself")
        self._posted.append(item)

    @property
    def waiting(self) -> bool:
        """Whether items are waiting for the next tick."""
        return bool(self._posted)

    def freeze(self) -> None:
        """Begin a tick: make the items of the previous tick visible."""
        self.visible, self._posted = self._posted, []
        self.ticks += 1

    def clear(self) -> None:
        """Discard the visible items and those that are waiting for the next tick."""
        self.visible, self._posted = (), []


class Mailbox(Stateful):
    """The access of one node to an event queue. An item that is posted in one tick can be taken in the next.

    Each mailbox of a queue gets all items of the queue, each item once.
    """

    kept = ("_taken",)

    def __init__(self, queue: EventQueue) -> None:
        self._queue = queue
        self._taken = 0

    def post(self, item: Any = None) -> None:
        """Queue an item for the next tick.

        Raises:
            ContextError: the queue is full.
        """
        self._queue.post(item)

    def take(self) -> Sequence[Any]:
        """Return the items that were posted in the previous tick, oldest first; a second call in the same tick returns none."""
        if self._taken == self._queue.ticks:
            return ()
        self._taken = self._queue.ticks
        return self._queue.visible


def find_impulses(queues: Mapping[str, EventQueue], node: str) -> tuple[str, EventQueue]:
    """Return the prim path and the impulse queue of an OnImpulseEvent node.

    Args:
        queues: queues of the session, by name.
        node: prim path of the node, or the last elements of the path if these are unique, such as `graph/Node` or `Node`.

    Raises:
        UsageError: no OnImpulseEvent node matches the path, or several do.
    """
    known = {name.removeprefix(IMPULSE): queue for name, queue in queues.items() if name.startswith(IMPULSE)}
    wanted = node.strip("/")
    meant = [path for path in known if f"/{path.strip('/')}".endswith(f"/{wanted}")] if wanted else []
    if len(meant) != 1:
        near = did_you_mean(node, known) or listing(known, "OnImpulseEvent nodes")
        what = "no OnImpulseEvent node" if not meant else f"{len(meant)} OnImpulseEvent nodes match"
        raise UsageError(f"{what} {node!r}\n  {listing(meant, 'write one of') if meant else near}")
    return meant[0], known[meant[0]]
