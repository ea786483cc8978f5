"""Writers and readers of the rclpy transport: rclpy publishers and subscriptions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.ros.transport import Deliver
from graphengine.ros.transports.ends import Remove, RosEnd


class RclEnd(RosEnd):
    """An endpoint that owns an rclpy object."""

    kind: str
    """Kind of the rclpy object as in rclpy's method names: `publisher` for `create_publisher`."""

    def __init__(self, name: str, remove: Remove) -> None:
        super().__init__(name, remove)
        self.entity: Any = None
        """The rclpy object, such as a Publisher; None after the endpoint is closed."""

    def end(self) -> None:
        """Drop the destroyed rclpy object; from now on, `opened` raises an error."""
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
    """A writer with an rclpy publisher; `dropped` stays 0, because rclpy does not report lost messages."""

    kind = "publisher"
    matched = 0

    def count(self, event: Any) -> None:
        """Update the number of readers from an rclpy event."""
        self.matched = event.current_count

    def write(self, data: bytes) -> None:
        """Send a message.

        With rmw_cyclonedds_cpp and the history keepAll, an unresponsive reader blocks this call for 10 s; then the RMW drops the
        reader.

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
    """A reader with an rclpy subscription.

    While any publisher on the topic has a different definition of the type, the reader drops all messages, because rclpy does
    not report the publisher of a message.

    Args:
        name: name of the topic.
        remove: called when the reader is closed.
        fits: returns whether all publishers on the topic define the type as this reader does.
        deliver: called with each message.
    """

    kind = "subscription"
    publishers = -1
    """Number of publishers at the last comparison of definitions."""
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
