"""A service client outside of a session: sends requests over a transport and returns futures of the responses."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.ros.transport import Transport
from graphengine.ros.transports.calls import MAX_OPEN

_POLL = 0.01


class ServiceCaller:
    """A client of a service.

        caller = ServiceCaller(transport, "/light", "std_srvs/srv/SetBool")
        response = caller.call(request).result(timeout=5.0)

    Args:
        transport: open transport; closing it also closes this client.
        service: full name of the service.
        service_type: ROS 2 name of the type.
        definitions: message types.

    Raises:
        MessageTypeError: the type is unknown.
    """

    def __init__(
        self, transport: Transport, service: str, service_type: str, definitions: Definitions = DEFINITIONS
    ) -> None:
        self._service = service
        _, self._response = definitions.service_parts(service_type)
        self._definitions = definitions
        self._lock = threading.Lock()
        self._open: dict[int, Future[Any]] = {}
        self._early: dict[int, bytes] = {}
        """For each call whose future `call` has not stored yet, by number: the response that already arrived."""
        self._client = transport.client(service, service_type, QoS(), self._receive)

    @property
    def ready(self) -> bool:
        """Whether a server of the service is matched."""
        return self._client.ready

    def becomes_ready(self, timeout: float) -> bool:
        """Wait until a server of the service is matched; return False if no server is matched within `timeout` s."""
        end = time.monotonic() + timeout
        while not self.ready and time.monotonic() < end:
            time.sleep(_POLL)
        return self.ready

    def call(self, request: Any) -> Future[Any]:
        """Send a request and return a future of the response; if there is no server, the request is lost.

        If more than `MAX_OPEN` calls are unanswered, the oldest call fails with a `TransportError`.

        Raises:
            MessageError: the message is not a request of the service.
            TransportError: the client is closed.
        """
        future = Future[Any]()
        number = self._client.call(messages.encode(request, self._definitions))
        dropped: Future[Any] | None = None
        with self._lock:
            early = self._early.pop(number, None)
            if early is None:
                self._open[number] = future
                if len(self._open) > MAX_OPEN:
                    dropped = self._open.pop(next(iter(self._open)))
        if early is not None:
            self._settle(future, early)
        if dropped is not None and not dropped.done():
            why = f"no response, and {MAX_OPEN} later calls are waiting"
            dropped.set_exception(TransportError(f"{self._service}: {why}"))
        return future

    def _receive(self, number: int, data: bytes) -> None:
        with self._lock:
            future = self._open.pop(number, None)
            if future is None:
                self._early[number] = data  # bounded, because the number may be that of a dropped call
                if len(self._early) > MAX_OPEN:
                    del self._early[next(iter(self._early))]
        if future is not None:
            self._settle(future, data)

    def _settle(self, future: Future[Any], data: bytes) -> None:
        try:
            future.set_result(messages.decode(data, self._response, self._definitions))
        except TransportError as error:
            future.set_exception(error)

    def close(self) -> None:
        """Close the client; safe to call twice."""
        self._client.close()
