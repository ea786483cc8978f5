"""Publishers and subscriptions of the transport over rclpy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.ros.transports.handing_over import HandingOver


@dataclass(eq=False, slots=True)
class RclWriter:
    """A publisher of rclpy."""

    topic: str
    remove: Callable[[RclWriter], None]
    matched: bool = False
    publisher: Any = None
    dropped: int = 0
    """0: rclpy does not count them."""

    def count(self, event: Any) -> None:
        """Take rclpy's event that readers came or went."""
        self.matched = event.current_count > 0

    def write(self, data: bytes) -> None:
        """Send one message.

        With rmw_cyclonedds_cpp and a history of keepAll this lasts until a reader that hangs is given up, which takes 10 s.

        Raises:
            TransportError: rclpy refuses it, or the writer is closed.
        """
        try:
            self.publisher.publish(data)
        except Exception as error:
            raise TransportError(f"{self.topic}: {len(data)} bytes were not sent: {error}") from error

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self.remove(self)


@dataclass(eq=False, slots=True)
class RclReader:
    """A subscription of rclpy.

    rclpy does not say which publisher sent a message: all of a topic are dropped while one has another definition.
    """

    topic: str
    fits: Callable[[RclReader], bool]
    deliver: Callable[[bytes], None]
    remove: Callable[[RclReader], None]
    malformed: int = 0
    """Messages that were dropped."""
    publishers: int = -1
    """Number of publishers when their definitions were last compared."""
    agrees: bool = True
    subscription: Any = None
    _hand_over: HandingOver = field(init=False)

    def __post_init__(self) -> None:
        self._hand_over = HandingOver(self.topic)

    def receive(self, data: bytes) -> None:
        """Deliver one message."""
        if self.fits(self):
            self._hand_over(self.deliver, data)
        else:
            self.malformed += 1

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self.remove(self)
