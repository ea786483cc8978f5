"""Hosts service servers that can respond after the session has executed the request."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.ros.transport import Complain, Transport, TransportServer

SERVICES = QoS()
"""QoS of all services: the default profile of rcl."""

Handle = Callable[[Any, Any], "Future[Any] | None"]
"""A function that is called with a request and the response to fill in, in a thread of the transport.

If the result is a future, the response is sent when the future is done; if the result is None, immediately.
"""


Finish = Callable[[Any, BaseException | None], None]
"""A function that is called with a response and the exception of `Handle`'s future (None without an exception)."""
Then = Callable[[Any, Any], None]
"""A function that is called with a request and its response."""


def _nothing(*_: object) -> None:
    """Ignore all arguments; the default for `finish` and `then`."""


class ServiceHost:
    """The service servers of one ROS node on a transport.

    Args:
        transport: transport on which the services are created.
        complain: called with one warning about malformed requests for each service.
        node: full name of the ROS node of the services; empty: the transport's node.
    """

    def __init__(self, transport: Transport, complain: Complain, node: str = "") -> None:
        self._transport = transport
        self._node = node
        self._complain = complain
        self._lock = threading.Lock()
        """Lock for `_servers`, because the transport may already deliver requests while it creates a service."""
        self._servers: dict[str, TransportServer] = {}
        self._malformed: set[str] = set()

    def add(
        self, service: str, service_type: str, handle: Handle, finish: Finish = _nothing, then: Then = _nothing
    ) -> None:
        """Create a service server.

        Args:
            service: full name of the service.
            service_type: name of the service type, such as `std_srvs/srv/Trigger`.
            handle: fills in the response; see `Handle`.
            finish: writes the outcome into the response before it is sent; see `Finish`.
            then: called after the response was sent; see `Then`.

        Raises:
            MessageTypeError: the transport does not know the type.
        """
        early: list[tuple[bytes, bytes]] = []
        """Requests that arrived while the transport was creating the service."""

        def deliver(request_id: bytes, data: bytes) -> None:
            with self._lock:
                if service not in self._servers:
                    early.append((request_id, data))
                    return
            request = self._decode(service, data, f"{service_type}_Request")
            if request is None:
                return
            response = DEFINITIONS.initial(f"{service_type}_Response")

            def reply(future: Future[Any] | None) -> None:
                finish(response, future.exception() if future is not None else None)
                with contextlib.suppress(TransportError):  # the service may have been closed meanwhile
                    self._servers[service].answer(request_id, messages.encode(response))
                then(request, response)

            future = handle(request, response)
            if future is None:
                reply(None)
            else:
                future.add_done_callback(reply)

        server = self._transport.server(service, service_type, SERVICES, deliver, self._node)
        with self._lock:
            self._servers[service] = server
        for arrival in early:
            deliver(*arrival)

    def _decode(self, service: str, data: bytes, message_type: str) -> Any | None:
        try:
            return messages.decode(data, message_type)
        except TransportError as error:
            if service not in self._malformed:
                self._malformed.add(service)
                what = f"a peer sends malformed {message_type} requests"
                self._complain(f"{service}: {what}, which are dropped ({error})")
            return None

    def close(self) -> None:
        """Destroy all services. Safe to call twice."""
        for server in self._servers.values():
            server.close()
