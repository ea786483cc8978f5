"""Publishers and subscriptions of the transport over rclpy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.ros.transport import Deliver
from graphengine.ros.transports.ends import Remove, RosEnd


class RclEnd(RosEnd):
    """An endpoint with its rclpy object."""

    kind: str
    """The endpoint's name in rclpy's methods, such as `publisher` in `create_publisher`."""

    def __init__(self, name: str, remove: Remove) -> None:
        super().__init__(name, remove)
        self.entity: Any = None
        """rclpy's object; None once it is closed."""

    def end(self) -> None:
        """Refuse further calls, because the rclpy object is destroyed."""
        self.entity = None

    def opened(self) -> Any:
        """Return the rclpy object.

        Raises:
            TransportError: the endpoint is closed.
        """
        entity = self.entity
        if entity is None:
            raise self.closed()
        return entity


class RclWriter(RclEnd):
    """An rclpy publisher; it does not count messages that readers lose."""

    kind = "publisher"
    matched = 0

    def count(self, event: Any) -> None:
        """Update the number of readers from an rclpy event."""
        self.matched = event.current_count

    def write(self, data: bytes) -> None:
        """Send a message.

        With rmw_cyclonedds_cpp and the history keepAll, this blocks until an unresponsive reader is dropped, after 10 s.

        Raises:
            TransportError: rclpy refuses the message, or the writer is closed.
        """
        entity = self.opened()
        try:
            entity.publish(data)
        except Exception as error:
            raise self.not_sent(data, error) from error

    def end(self) -> None:
        """Set the number of readers to 0."""
        super().end()
        self.matched = 0


class RclReader(RclEnd):
    """An rclpy subscription.

    rclpy does not report the publisher of a message, so all messages of a topic are dropped while one publisher has a different
    definition of the type.

    Args:
        name: name of the topic.
        remove: called when the reader is closed.
        fits: returns whether the topic's publishers have the same definition as this reader.
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
        """Deliver a message; drop and count it while a publisher has a different definition of the type."""
        if self._fits(self):
            self.hand_over(self._deliver, data)
        else:
            self.malformed += 1
