"""Publishers and subscriptions of the transport over rclpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.ros.transport import Deliver
from graphengine.ros.transports.ends import Remove, RosEnd


class RclEnd(RosEnd):
    """An endpoint that rclpy made."""

    kind: str
    """What rclpy calls it, as in `create_publisher`."""

    def __init__(self, name: str, remove: Remove) -> None:
        super().__init__(name, remove)
        self.entity: Any = None
        """rclpy's object; None once it is closed."""

    def end(self) -> None:
        """Refuse what rclpy's object cannot do any more."""
        self.entity = None

    def opened(self) -> Any:
        """The object of rclpy.

        Raises:
            TransportError: it is closed.
        """
        entity = self.entity
        if entity is None:
            raise self.closed()
        return entity


class RclWriter(RclEnd):
    """A publisher of rclpy; it does not count messages that readers lose."""

    kind = "publisher"
    matched = 0

    def count(self, event: Any) -> None:
        """Take rclpy's event that readers came or went."""
        self.matched = event.current_count

    def write(self, data: bytes) -> None:
        """Send one message.

        With rmw_cyclonedds_cpp and a history of keepAll this lasts until a reader that hangs is given up, which takes 10 s.

        Raises:
            TransportError: rclpy refuses it, or the writer is closed.
        """
        entity = self.opened()
        try:
            entity.publish(data)
        except Exception as error:
            raise self.not_sent(data, error) from error

    def end(self) -> None:
        """Have no readers."""
        super().end()
        self.matched = 0


class RclReader(RclEnd):
    """A subscription of rclpy.

    rclpy does not say which publisher sent a message: all of a topic are dropped while one has another definition.

    Args:
        name: of its topic.
        remove: called when it is closed.
        fits: whether the publishers of the topic have the definition here.
        deliver: called with each message.
    """

    kind = "subscription"
    publishers = -1
    """Number of publishers when their definitions were last compared."""
    agrees = True

    def __init__(self, name: str, remove: Remove, fits: Callable[[RclReader], bool], deliver: Deliver) -> None:
        super().__init__(name, remove)
        self._fits = fits
        self._deliver = deliver

    def receive(self, data: bytes) -> None:
        """Deliver one message."""
        if self._fits(self):
            self.hand_over(self._deliver, data)
        else:
            self.malformed += 1
