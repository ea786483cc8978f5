"""Service servers and clients of the rclpy transport, with encoded messages; a server can respond at any time.

Normally, the callback of an rclpy service returns the response, which rclpy passes to `send_response` with the header of the
request. Here, the callback returns the request, and `send_response` is replaced: the replacement delivers the request and
keeps the header for the response.
"""

from __future__ import annotations

import logging
import threading
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

from graphengine.messages import names
from graphengine.ros.transport import DeliverRequest, DeliverResponse
from graphengine.ros.transports import vendors
from graphengine.ros.transports.calls import Calls
from graphengine.ros.transports.ends import Remove
from graphengine.ros.transports.rcl.rcl_endpoints import RclEnd

Later = Callable[[Callable[[], None]], object]
"""Function that runs a function later, in the transport's thread."""

_log = logging.getLogger(__name__)
_warnings_lock = threading.Lock()
_ATTEMPTS = 20
"""Number of attempts to send a response; in each, the RMW waits up to 0.1 s for the discovery of the client's reader."""


class _RclService(RclEnd):
    """A service server or client with an rclpy object.

    Args:
        name: name of the service.
        remove: called when the endpoint is closed.
        deliver: called with identity and bytes of each request, or with call number and bytes of each response.
        node: rclpy node that looks up the peers.
    """

    def __init__(self, name: str, remove: Remove, deliver: Callable[[Any, bytes], None], node: Any) -> None:
        super().__init__(name, remove)
        self._deliver = deliver
        self._node = node

    def warning(self) -> str:
        """Return a warning about incompatible peers; empty if there are none."""
        import rclpy

        found = "publishers" if self.peer == "client" else "subscriptions"
        asking = getattr(self._node, f"get_{found}_info_by_topic")(names.service_topics(self.name)[0], no_mangle=True)
        gids = [bytes(end.endpoint_gid) for end in asking]
        return vendors.warning(self.name, self.peer, gids, rclpy.get_rmw_implementation_identifier())

    def _decoded(self, data: bytes, message: type) -> Any:
        from rclpy.serialization import deserialize_message

        try:
            if len(data) <= 4:
                raise ValueError("the message is empty after the encapsulation header")
            return deserialize_message(data, message)
        except Exception as error:
            raise self.not_sent(data, error) from error

    def _serialize(self, call: Any, message: Any) -> None:
        from rclpy.serialization import serialize_message

        self.hand_over(lambda: self._deliver(call, serialize_message(message)))


class RclServer(_RclService):
    """A service server with an rclpy service, which can send a response at any time after the request.

    A server can receive a request from a client whose reader it has not discovered yet. The RMW then drops a response after
    0.1 s; the transport's thread makes the remaining attempts.

    Args:
        name: name of the service.
        remove: called when the server is closed.
        deliver: called with identity and bytes of each request.
        node: rclpy node that looks up the peers.
        later: called with a function to run in the transport's thread.
    """

    kind = "service"
    peer = "client"

    def __init__(self, name: str, remove: Remove, deliver: DeliverRequest, node: Any, later: Later) -> None:
        super().__init__(name, remove, deliver, node)
        self._later = later
        self._begun = threading.Event()
        self._calls = Calls()
        """Headers of unanswered requests."""

    def begin(self) -> None:
        """Replace `send_response` and start to deliver requests; called after rclpy has created the service."""
        self.entity.send_response = self._receive
        self._begun.set()

    def returned(self, request: Any, response: Any) -> Any:
        """Callback of the rclpy service: return the request, which rclpy passes to the replaced `send_response`."""
        self._begun.wait()
        return request

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send a response.

        Raises:
            TransportError: the server is closed, or the bytes are not a message of the service's type.
        """
        entity = self.opened()
        header = self._calls.end(int.from_bytes(request_id, "big"))
        if header is None:
            return
        message = self._decoded(response, entity.srv_type.Response)
        try:
            self._send(message, header, _ATTEMPTS)
        except Exception as error:
            raise self.not_sent(response, error) from error

    def _send(self, response: Any, header: Any, attempts: int) -> None:
        """Send a response; if the RMW drops it, send it again in the transport's thread until no attempts are left."""
        from rclpy.service import Service

        entity = self.entity
        if entity is None:  # closed since the first attempt
            return
        with _warnings_lock, warnings.catch_warnings(record=True) as dropped:
            # A warning is rclpy's only report that the client's reader is not discovered.
            warnings.simplefilter("always", RuntimeWarning)
            Service.send_response(entity, response, header)
        if not dropped:
            return
        if attempts > 1:
            self._later(partial(self._send, response, header, attempts - 1))
        else:
            _log.warning("a response of service %s was dropped: its client was not discovered completely", self.name)

    def _receive(self, request: Any, header: Any) -> None:
        self._serialize(self._calls.begin(header).to_bytes(8, "big"), request)


class RclClient(_RclService):
    """A service client with an rclpy client; it sends encoded requests and delivers encoded responses."""

    kind = "client"
    peer = "server"

    def __init__(self, name: str, remove: Remove, deliver: DeliverResponse, node: Any) -> None:
        super().__init__(name, remove, deliver, node)
        self._calls = Calls(self._give_up)
        """rclpy futures of unanswered calls; a call that `Calls` discards is removed from rclpy too."""

    @property
    def ready(self) -> bool:
        """Whether a matching server exists."""
        entity = self.entity
        return entity is not None and bool(entity.service_is_ready())

    def call(self, request: bytes) -> int:
        """Send a request; return the number of the call.

        Raises:
            TransportError: the client is closed, or the bytes are not a message of the service's type.
        """
        entity = self.opened()
        message = self._decoded(request, entity.srv_type.Request)
        try:
            future = entity.call_async(message)
        except Exception as error:
            raise self.not_sent(request, error) from error
        number = self._calls.begin(future)
        future.add_done_callback(partial(self._receive, number))
        return number

    def _give_up(self, future: Any) -> None:
        if (entity := self.entity) is not None:
            entity.remove_pending_request(future)

    def _receive(self, number: int, future: Any) -> None:
        if self._calls.end(number) is not None and self.entity is not None:
            self._serialize(number, future.result())
