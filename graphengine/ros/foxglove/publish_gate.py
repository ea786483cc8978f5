"""A gate in front of Foxglove's SDK server: clients that have the token of the run may publish.

The SDK checks neither a token nor the origin of a web page. So the SDK's server accepts no messages of clients, and listens only
on the loopback interface. The gate connects each client that has the token to this server, and gives messages that the client
publishes to the run.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import logging
import socket
import struct
import threading
from collections.abc import Mapping
from typing import Any, Protocol

from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from graphengine.format.web_access import has_token, make_token, parse_object

SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
MESSAGE_DATA, HEADER = 1, struct.Struct("<BI")
"""Opcode of a message that a client publishes, and format of the message's header: opcode and id of the client's channel."""
MAX_CLIENTS = 16
"""Maximum number of clients of `--foxglove-publish` at the same time."""
MAX_MESSAGE = 16_000_000
"""Maximum size of a message from a client, bytes."""
MAX_TEXT = 100_000
"""Maximum size of a text from a client, characters; the run waits while the text is parsed."""
CLOSING = 0.5
"""Maximum wait for a client at the end, s."""

_quiet = logging.getLogger(__name__)
_quiet.setLevel(logging.CRITICAL + 1)  # websockets logs the bytes of each malformed request
_OPTIONS: Any = {"subprotocols": [SUBPROTOCOL], "compression": None, "close_timeout": CLOSING, "logger": _quiet}


class ClientPublishers(Protocol):
    """Receives the publishers and messages of clients; `client` is a client's number, `channel` the client's id of a channel."""

    def announce(self, client: int, told: Mapping[str, Any]) -> bool:
        """Add or remove publishers of a client; return False if the client's message does neither."""

    def receive(self, client: int, channel: int, data: bytes) -> None:
        """Process a client's message."""

    def forget(self, client: int) -> None:
        """Remove all publishers of a client that has disconnected."""


class PublishGate:
    """Serves clients that have the token until `close`.

    Args:
        host: host to listen on.
        port: TCP port; 0 selects a free port.
        inner: URL of the SDK's server.
        publishers: receives the publishers and messages of clients, in the gate's thread.

    Raises:
        OSError: the address cannot be used.
    """

    def __init__(self, host: str, port: int, inner: str, publishers: ClientPublishers) -> None:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        self._socket = socket.create_server((host, port), family=family)
        self.port: int = self._socket.getsockname()[1]
        self.token = make_token()
        self._inner = inner
        self._publishers = publishers
        self._numbers = itertools.count()
        self._clients: set[ServerConnection] = set()
        self._loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="foxglove gate", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Disconnect all clients and free the port; call it once."""
        self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:  # whose end cancels what still runs
            runner.run(self._serve())

    async def _serve(self) -> None:
        server = await serve(
            self._handle, sock=self._socket, process_request=self._check, max_size=MAX_MESSAGE, **_OPTIONS
        )
        await self._ended.wait()
        server.close()
        await asyncio.wait([asyncio.ensure_future(server.wait_closed())], timeout=CLOSING)
        for client in self._clients:  # that do not read
            client.transport.abort()

    def _check(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return None for a request with the token, otherwise the response that refuses it."""
        if has_token(request.path, self.token):
            return None
        return connection.respond(403, "open the address that graphrun printed: it contains the token of this run\n")

    async def _handle(self, client: ServerConnection) -> None:
        if len(self._clients) >= MAX_CLIENTS:
            await client.close(1013, f"there are already {MAX_CLIENTS} clients")
            return
        number = next(self._numbers)
        self._clients.add(client)
        try:
            # Without pings, because the answers would wait behind messages for a client that is slow.
            async with connect(self._inner, proxy=None, max_size=None, ping_interval=None, **_OPTIONS) as inner:
                await (await inner.ping())  # the server sends warnings to this client from now on
                sending = asyncio.ensure_future(_send(inner, client))
                async for message in client:
                    if isinstance(message, str) and len(message) > MAX_TEXT:
                        await client.close(1009, f"a text has at most {MAX_TEXT} characters")
                        break
                    if not self._take(number, message):
                        await inner.send(message)
                        await (await inner.ping())  # a subscription holds before the client's next message
                sending.cancel()
        except (ConnectionClosed, OSError):
            pass
        finally:
            self._clients.discard(client)
            self._publishers.forget(number)

    def _take(self, client: int, message: str | bytes) -> bool:
        """Pass a message with which a client publishes or advertises to the run; return False for any other message."""
        if isinstance(message, str):
            return self._publishers.announce(client, parse_object(message) or {})
        if len(message) < HEADER.size or message[0] != MESSAGE_DATA:
            return False
        self._publishers.receive(client, HEADER.unpack_from(message)[1], message[HEADER.size :])
        return True


async def _send(inner: ClientConnection, client: ServerConnection) -> None:
    """Send the SDK server's messages to a client until server or client closes; add `clientPublish` to the capabilities."""
    with contextlib.suppress(ConnectionClosed):
        async for message in inner:
            if isinstance(message, str) and (told := parse_object(message)) and told.get("op") == "serverInfo":
                message = json.dumps({**told, "capabilities": ["clientPublish"]})
            await client.send(message)
    await client.close()
