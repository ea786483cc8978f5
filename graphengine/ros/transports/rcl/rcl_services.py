"""Services over rclpy, where requests are answered at any time, and messages are encoded at both ends.

rclpy answers with what a service's callback returns, when it returns. Here that is the request itself, and instead of sending
it, `send_response`, which rclpy gives a request's header, delivers it.
"""

from __future__ import annotations

import itertools
import threading
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages import names
from graphengine.ros.transports import vendors
from graphengine.ros.transports.calls import MAX_OPEN
from graphengine.ros.transports.handing_over import HandingOver


class _End:
    """A server or client of rclpy."""

    def __init__(self, service: str, remove: Callable[[Any], None]) -> None:
        self.service = service
        self.entity: Any = None
        """What rclpy knows it by; None once it is closed."""
        self._remove = remove
        self._handing_over = HandingOver(service)

    def close(self) -> None:
        """Leave the service; a second time does nothing."""
        self._remove(self)

    def _opened(self) -> Any:
        entity = self.entity
        if entity is None:
            raise TransportError(f"{self.service} is closed")
        return entity

    def _decoded(self, data: bytes, message: type) -> Any:
        from rclpy.serialization import deserialize_message

        try:
            if len(data) <= 4:
                raise ValueError("there is nothing behind the encapsulation header")
            return deserialize_message(data, message)
        except Exception as error:
            raise self._not_sent(data, error) from error

    def _not_sent(self, data: bytes, error: Exception) -> TransportError:
        return TransportError(f"{self.service}: {len(data)} bytes were not sent: {error}")

    def _hand_over(self, deliver: Callable[[Any, bytes], None], call: Any, message: Any) -> None:
        from rclpy.serialization import serialize_message

        self._handing_over(lambda: deliver(call, serialize_message(message)))


class RclServer(_End):
    """A service of rclpy."""

    def __init__(self, service: str, deliver: Callable[[bytes, bytes], None], remove: Callable[[Any], None]) -> None:
        super().__init__(service, remove)
        self._deliver = deliver
        self._begun = threading.Event()
        self._numbers = itertools.count(1)
        self._headers: dict[bytes, Any] = {}
        """Of requests that wait for their answers."""

    def open(self, create: Callable[[Callable[[Any, Any], Any]], Any]) -> None:
        """Begin, with what makes a service of a callback."""
        self.entity = create(self._returned)
        self.entity.send_response = self._receive
        self._begun.set()

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send an answer.

        Raises:
            TransportError: the server is closed, or it is no message of the service's type.
        """
        from rclpy.service import Service

        entity = self._opened()
        header = self._headers.pop(request_id, None)
        if header is None:
            return
        message = self._decoded(response, entity.srv_type.Response)
        try:
            with warnings.catch_warnings():
                # rclpy warns where the client is there no more.
                warnings.simplefilter("ignore", RuntimeWarning)
                Service.send_response(entity, message, header)
        except Exception as error:
            raise self._not_sent(response, error) from error

    def warning(self, node: Any) -> str:
        """What to tell people about clients that cannot be talked to; empty where there are none."""
        asking = node.get_publishers_info_by_topic(names.service_topics(self.service)[0], no_mangle=True)
        return _warning(self.service, "client", asking)

    def _returned(self, request: Any, response: Any) -> Any:
        self._begun.wait()
        return request

    def _receive(self, request: Any, header: Any) -> None:
        request_id = next(self._numbers).to_bytes(8, "big")
        self._headers[request_id] = header
        if len(self._headers) > MAX_OPEN:
            del self._headers[next(iter(self._headers))]
        self._hand_over(self._deliver, request_id, request)


class RclClient(_End):
    """A client of rclpy."""

    def __init__(self, service: str, deliver: Callable[[int, bytes], None], remove: Callable[[Any], None]) -> None:
        super().__init__(service, remove)
        self._deliver = deliver
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._waiting: dict[int, Any] = {}
        """Calls that rclpy keeps until they are answered, by number."""

    @property
    def ready(self) -> bool:
        """Whether a server is there that matches."""
        entity = self.entity
        return entity is not None and bool(entity.service_is_ready())

    def call(self, request: bytes) -> int:
        """Send a request, and return its number.

        Raises:
            TransportError: the client is closed, or it is no message of the service's type.
        """
        entity = self._opened()
        message = self._decoded(request, entity.srv_type.Request)
        with self._lock:
            number = next(self._numbers)
            try:
                future = self._waiting[number] = entity.call_async(message)
            except Exception as error:
                raise self._not_sent(request, error) from error
            if len(self._waiting) > MAX_OPEN:
                entity.remove_pending_request(self._waiting.pop(next(iter(self._waiting))))
        future.add_done_callback(partial(self._receive, number))
        return number

    def warning(self, node: Any) -> str:
        """What to tell people about servers that cannot be talked to; empty where there are none."""
        asked = node.get_subscriptions_info_by_topic(names.service_topics(self.service)[0], no_mangle=True)
        return _warning(self.service, "server", asked)

    def _receive(self, number: int, future: Any) -> None:
        with self._lock:
            waited = self._waiting.pop(number, None)
        if waited is not None and self.entity is not None:
            self._hand_over(self._deliver, number, future.result())


def _warning(service: str, peer: str, ends: Sequence[Any]) -> str:
    import rclpy

    gids = [bytes(end.endpoint_gid) for end in ends]
    return vendors.warning(service, peer, gids, rclpy.get_rmw_implementation_identifier())
