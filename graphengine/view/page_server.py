"""Serves all parts of the page on one port: its files, viser's 3D part, and the live values.

By default, viser opens a port on all interfaces without access control, accepts messages of up to 50 MB, and lets each client
request a public tunnel. So this module replaces the function of the package websockets with which viser opens its port. The
replacement binds to one address, lets a `PageGuard` check each request, and limits the size of messages and the number of
viewers. Everybody gets the files of the page, which are the same for all runs; the two WebSockets need the token. Requests for
tunnels are disabled too. It also replaces the event by which viser's queues wake the server's thread: viser sets it in the thread
that draws, but an event of asyncio is not thread-safe and can raise RuntimeError there.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import itertools
import json
import logging
import mimetypes
import os
import socket
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator, Mapping
from http import HTTPStatus
from importlib import resources
from typing import Any

import viser
import websockets.asyncio.server as websocket_server
from viser import _client_autobuild, _messages
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from graphengine.format.errors import UsageError
from graphengine.format.web_access import make_token, parse_object
from graphengine.view.guard import PageGuard
from graphengine.view.kept_token import kept_token

MAX_VIEWERS = 8
"""Maximum number of viewers of a page at the same time."""
FAREWELL = 1.0
"""Maximum wall time for sending the last message to viewers at the end of the run, s."""
MAX_MESSAGE = 1_000_000
"""Maximum size of a message from a browser, bytes; a larger one ends the connection."""
MAX_REQUEST = 64_000
"""Maximum size of a request on the feed, characters; a larger one is refused with an answer."""
MAX_UNREAD = 8_000_000
"""Size of unsent answers above which a viewer is disconnected, characters."""
EVERY_ADDRESS = ("0.0.0.0", "::")
SCENE, FEED = "/3d", "/feed"
"""URL paths: the page and WebSocket of viser, and the WebSocket of the feed, which sends live values."""
_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; frame-ancestors 'self'; "
    "base-uri 'none'; form-action 'none'"
)
_POLICY_3D = "connect-src 'self' data: blob:; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
"""Policy of viser's page. Its address names its WebSocket; that of a stranger could run scripts in the page."""
_STATIC = resources.files(__package__).joinpath("static")
_HTML = resources.files(__package__).joinpath("html")
_FILES = {f"/{file.name}": file for file in _STATIC.iterdir()}
_FILES |= {"/": _FILES["/page.html"], **{f"/{name}": _HTML.joinpath(name) for name in ("uplot.js", "uplot.css")}}

_log = logging.getLogger(__name__)
_log.addFilter(
    lambda record: record.msg != "opening handshake failed"
)  # it has all bytes of the request and a traceback

Handler = Callable[[ServerConnection], Awaitable[None]]


class _News(asyncio.Event):
    """An event that other threads may set; they wake no waiter, because viser sets it again in the thread of the event loop."""

    def set(self) -> None:
        """Set the event. In the thread of the event loop, also wake all waiters."""
        self._value = True
        try:
            asyncio.get_running_loop()
        except RuntimeError:  # another thread
            return
        for waiter in self._waiters:
            if not waiter.done():
                waiter.set_result(True)


class _Queue(AsyncMessageBuffer):
    """A queue of viser with an event that other threads may set."""

    def __init__(self, event_loop: asyncio.AbstractEventLoop, persistent_messages: bool) -> None:
        super().__init__(event_loop, persistent_messages, message_event=_News())


_infra.AsyncMessageBuffer = _Queue  # type: ignore[attr-defined, assignment]


class Viewer:
    """A browser that receives live values; of several unsent messages of one kind, only the newest is kept."""

    def __init__(self, number: int, connection: ServerConnection) -> None:
        self.number = number
        self.tab = _tab(connection)
        """Name of the tab, which its connection to the 3D part has too."""
        self.connection = connection
        self._waiting: dict[str, str] = {}
        self._answers: list[str] = []
        self.unread = 0
        """Size of the unsent answers, characters."""
        self._news = asyncio.Event()

    def put(self, kind: str, text: str) -> None:
        """Queue a message; it replaces an unsent message of the same kind."""
        self._waiting[kind] = text
        self._news.set()

    def answer(self, text: str) -> None:
        """Queue a message that no other message replaces."""
        self._answers.append(text)
        self.unread += len(text)
        self._news.set()

    async def take(self) -> list[str]:
        """Wait until messages are queued; return and remove them."""
        await self._news.wait()
        self._news.clear()
        return self.drain()

    def drain(self) -> list[str]:
        """Return and remove the queued messages without waiting."""
        found = [*self._answers, *self._waiting.values()]
        self._answers.clear()
        self._waiting.clear()
        self.unread = 0
        return found


class PageServer:
    """Serves the page until it is closed.

    Args:
        host: IP address to bind to.
        port: TCP port; 0 selects a free port.
        asked: called with each message of a viewer, in the server's thread.
        greet: returns the first messages for a new viewer, by kind.
        keep_token: whether the next run on this port gets the same token, and this run the token of the last one. Only a page
            on a loopback address keeps its token.

    Raises:
        UsageError: the page cannot be served at this address.
    """

    def __init__(
        self,
        host: str,
        port: int,
        asked: Callable[[Viewer, Mapping[str, Any]], None],
        greet: Callable[[], Mapping[str, str]],
        keep_token: bool = False,
    ) -> None:
        self._asked = asked
        self._greet = greet
        self._numbers = itertools.count()
        self.viewers: dict[int, Viewer] = {}
        self._sockets: Counter[bool] = Counter()
        """Number of open WebSocket connections, by whether they belong to the feed (True) or to viser (False)."""
        self._socket = _listen(host, port)
        self.port = self._socket.getsockname()[1]
        hosts = [f"[{name}]:{self.port}" if ":" in name else f"{name}:{self.port}" for name in _names(host)]
        keep_token = keep_token and ipaddress.ip_address(host).is_loopback
        token = kept_token(port, os.environ) if keep_token else make_token()
        self._guard = PageGuard(tuple(hosts), host in EVERY_ADDRESS, token)
        self.url = f"http://{hosts[0]}/#token={self._guard.token}"
        with _served_by(self._serve), contextlib.redirect_stdout(None):
            self.viser = viser.ViserServer(host, port, verbose=False)
        for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
            self.viser._websock_server.unregister_handler(message)
        self.viser.gui.configure_theme(show_logo=False, show_share_button=False)

    def tab_of(self, client: int) -> str:
        """Return the name of the tab that a client of viser belongs to; empty for a client without a page."""
        connection = self.viser._websock_server._live_connections.get(client)
        return _tab(connection) if connection is not None else ""

    def viewers_in(self, tab: str) -> list[int]:
        """Return the numbers of the viewers in a tab: one, or none while its page is closed."""
        return [viewer.number for viewer in list(self.viewers.values()) if tab and viewer.tab == tab]

    def broadcast(self, kind: str, text: str) -> None:
        """Send a message to all viewers; it replaces an unsent message of the same kind. Thread-safe."""
        self._loop.call_soon_threadsafe(self._put, kind, text)

    def answer(self, viewer: int, text: str) -> None:
        """Send a message to one viewer, if it is still connected; thread-safe."""
        self._loop.call_soon_threadsafe(self._answer_viewer, viewer, text)

    def tell(self, viewer: int, kind: str, text: str) -> None:
        """Send a message to one viewer; it replaces an unsent message of the same kind. Thread-safe."""
        self._loop.call_soon_threadsafe(self._tell_viewer, viewer, kind, text)

    def _tell_viewer(self, number: int, kind: str, text: str) -> None:
        if number in self.viewers:
            self.viewers[number].put(kind, text)

    def answer_all(self, text: str) -> None:
        """Send a message to all viewers, which no other message replaces; thread-safe."""
        for number in list(self.viewers):
            self.answer(number, text)

    def _answer_viewer(self, number: int, text: str) -> None:
        viewer = self.viewers.get(number)
        if viewer is None:
            return
        viewer.answer(text)
        if viewer.unread > MAX_UNREAD:
            viewer.connection.transport.abort()

    def _put(self, kind: str, text: str) -> None:
        for viewer in self.viewers.values():
            viewer.put(kind, text)

    def end(self, text: str) -> None:
        """Send the queued messages and then `text` to all viewers, and disconnect them."""

        async def tell(viewer: Viewer) -> None:
            with contextlib.suppress(ConnectionClosed):
                for left in (*viewer.drain(), text):
                    await viewer.connection.send(left)
                await viewer.connection.close(1001, "the run has ended")

        async def tell_all() -> None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(FAREWELL):
                    await asyncio.gather(*map(tell, self.viewers.values()))

        asyncio.run_coroutine_threadsafe(tell_all(), self._loop).result()

    def close(self) -> None:
        """Stop the server and disconnect all viewers."""
        with contextlib.redirect_stdout(None):
            self.viser.stop()
        self._socket.close()

    # In the server's thread

    def _serve(self, handler: Handler, host: str, port: int, **options: Any) -> Any:
        """Open viser's port in place of `websockets.asyncio.server.serve`; check requests, limit viewers, and serve the feed."""
        show = options.pop("process_request")
        self._loop = asyncio.get_running_loop()

        async def handle(connection: ServerConnection) -> None:
            assert connection.request is not None
            feed = _path(connection.request) == FEED
            if self._sockets[feed] >= MAX_VIEWERS:
                await connection.close(1013, f"the page already has {MAX_VIEWERS} viewers")
                return
            self._sockets[feed] += 1
            try:
                await (self._feed(connection) if feed else handler(connection))
            finally:
                self._sockets[feed] -= 1

        def answer(connection: ServerConnection, request: Request) -> Response | None:
            return self._answer(request, lambda plain: show(connection, plain))

        options |= {"max_size": MAX_MESSAGE, "process_request": answer, "logger": _log}
        return _original(handle, sock=self._socket, **options)

    def _answer(self, request: Request, show: Callable[[Request], Response]) -> Response | None:
        """Return the response to a request, or None to open a WebSocket; `show` returns viser's response."""
        path = _path(request)
        is_socket = path in (FEED, SCENE)
        if refused := self._guard.check(request.path, request.headers.raw_items(), secret=is_socket):
            return _response(403, "text/plain", f"{refused}\n".encode())
        if is_socket:
            return None
        if path in _FILES:
            file = _FILES[path]
            return _response(200, mimetypes.guess_type(file.name)[0] or "text/plain", file.read_bytes())
        if path == f"{SCENE}/":  # viser's page is one file; of the headers, viser looks up one, which could be doubled
            zipped = any("gzip" in value for value in request.headers.get_all("Accept-Encoding"))
            page = show(Request("/", Headers({"Accept-Encoding": "gzip"} if zipped else {})))
            page.headers.update({"Referrer-Policy": "no-referrer", "Content-Security-Policy": _POLICY_3D})
            return page
        return _response(404, "text/plain", b"there is no such file\n")

    async def _feed(self, connection: ServerConnection) -> None:
        """Serve a viewer until it disconnects: send queued messages to it, and pass its requests on."""
        viewer = Viewer(next(self._numbers), connection)
        self.viewers[viewer.number] = viewer
        for kind, text in self._greet().items():
            viewer.put(kind, text)
        self._asked(viewer, {"ask": "come"})
        sending = asyncio.ensure_future(_send(connection, viewer))
        try:
            async for given in connection:
                message = parse_object(given)
                if message is None:
                    await connection.close(1003, "send a JSON object")
                    break
                if len(given) > MAX_REQUEST:
                    error = f"the request is too long: {len(given)} characters; at most {MAX_REQUEST} are accepted"
                    viewer.answer(json.dumps({"answer": {"id": number_of(message), "error": error}}))
                    continue
                self._asked(viewer, message)
        except ConnectionClosed:
            pass
        finally:
            del self.viewers[viewer.number]
            sending.cancel()
            self._asked(viewer, {"ask": "gone"})


async def _send(connection: ServerConnection, viewer: Viewer) -> None:
    with contextlib.suppress(ConnectionClosed):
        while True:
            for text in await viewer.take():
                await connection.send(text)


def number_of(message: Mapping[str, Any]) -> int | None:
    """Return the number that a viewer gave its request, which the answer repeats; None without an integer."""
    number = message.get("id")
    return number if type(number) is int else None


def _tab(connection: ServerConnection) -> str:
    """Return the name of a tab in the query of a request, at most 64 characters."""
    query = connection.request.path.partition("?")[2] if connection.request is not None else ""
    names = [part.removeprefix("tab=") for part in query.split("&") if part.startswith("tab=")]
    return names[0][:64] if names else ""


def _path(request: Request) -> str:
    return request.path.partition("?")[0]


def _response(status: int, kind: str, body: bytes) -> Response:
    fields = {"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), "Connection": "close"}
    fields |= {"Content-Security-Policy": _POLICY, "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store"}
    fields["Referrer-Policy"] = "no-referrer"
    return Response(status, HTTPStatus(status).phrase, Headers(fields), body)


def _names(host: str) -> list[str]:
    """Return the host names by which the page can be reached; the user sees the first name."""
    if host in EVERY_ADDRESS:
        return [socket.gethostname(), "localhost"]
    return [host, "localhost"] if ipaddress.ip_address(host).is_loopback else [host]


def _listen(host: str, port: int) -> socket.socket:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        raise UsageError(f"{host!r} is not an IP address for the page; use one such as 127.0.0.1") from None
    if not 0 <= port <= 65535:
        raise UsageError(f"the page cannot be served on port {port}: ports are numbers from 0 to 65535")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except OSError as error:
        raise UsageError(f"the page cannot be served on {host}, port {port}: {error.strerror or error}") from None


_original = websocket_server.serve


@contextlib.contextmanager
def _served_by(serve: Callable[..., Any]) -> Iterator[None]:
    """Return a context in which viser opens its port with `serve` instead of the function of the package websockets."""
    build = _client_autobuild.ensure_client_is_built
    websocket_server.serve = serve  # type: ignore[assignment, misc]
    _client_autobuild.ensure_client_is_built = lambda: None  # which would download Node.js if dates of files look wrong
    try:
        yield
    finally:
        websocket_server.serve = _original  # type: ignore[misc]
        _client_autobuild.ensure_client_is_built = build
