"""The server of the page: one port, closed to whoever has no token, with bounds on viewers and messages."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from graphengine.format.errors import UsageError
from graphengine.view.page_server import _STATIC, FEED, MAX_MESSAGE, MAX_REQUEST, MAX_VIEWERS, SCENE, PageServer
from tests.view.harness import socket_of
from tests.waiting import eventually

STRANGER = r"""
import os, socket, sys
connection, port = socket.socket(), int(sys.argv[1])
os.setuid(65534)
connection.connect(("127.0.0.1", port))
connection.sendall(b"GET /feed HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n" % port)
print(connection.recv(100).partition(b"\r\n")[0].decode())
"""


class Served:
    """A server, and what its viewers asked."""

    def __init__(self) -> None:
        self.asked: list[Any] = []
        self.server = PageServer(
            "127.0.0.1", 0, lambda viewer, message: self.asked.append(message), lambda: {"stage": '{"stage": {}}'}
        )
        self.host = f"127.0.0.1:{self.server.port}"
        self.token = self.server.url.partition("#token=")[2]

    def get(self, path: str, **headers: str) -> tuple[int, str]:
        """Status and body of a request; a header without a value is left out."""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=10)
        connection.request(
            "GET", path, headers={n: value for n, value in {"Host": self.host, **headers}.items() if value}
        )
        answer = connection.getresponse()
        body = answer.read().decode(errors="replace")
        connection.close()
        return answer.status, body

    def send(self, request: bytes) -> bytes:
        """First line of what is answered to bytes."""
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=20) as connection:
            connection.sendall(request)
            return connection.makefile("rb").readline()

    def connect(self, path: str = FEED, *, token: str | None = None, **headers: str) -> ClientConnection:
        """A WebSocket of a viewer."""
        url = self.server.url if token is None else f"http://{self.host}/#token={token}"
        protocols: Any = ["viser-v1.1.1"] if path == SCENE else None
        return connect(
            socket_of(url, path),
            additional_headers=headers,
            subprotocols=protocols,
            max_size=None,
            close_timeout=0.5,  # s; what was not read holds the closing up
        )


@pytest.fixture
def served() -> Iterator[Served]:
    made = Served()
    yield made
    made.server.close()


@pytest.mark.parametrize("path", ["/", "/page.js", "/page.css", f"{SCENE}/", f"{SCENE}/?darkMode&websocket=x"])
def test_everybody_gets_the_files_of_the_page_which_hold_nothing_of_the_run(served: Served, path: str) -> None:
    status, body = served.get(path)
    assert status == 200
    assert body
    assert served.token not in body


def test_the_3d_part_connects_to_its_own_server_only_and_sends_its_address_to_nobody(served: Served) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", served.server.port, timeout=10)
    connection.request("GET", f"{SCENE}/", headers={"Host": served.host})
    answer = connection.getresponse()
    assert answer.headers["Referrer-Policy"] == "no-referrer"
    assert "connect-src 'self' data: blob:" in answer.headers["Content-Security-Policy"]
    assert "Set-Cookie" not in answer.headers
    connection.close()


def test_all_modules_of_the_page_are_loaded_at_once(served: Served) -> None:
    _, page = served.get("/")
    modules = {file.name for file in _STATIC.iterdir() if file.name.endswith(".js")} - {
        "page.js",
        "token.js",
        "world.js",
    }
    assert set(re.findall(r'rel="modulepreload" href="([^"]+)"', page)) == modules


@pytest.mark.parametrize("path", ["/", "/page.js", SCENE, f"{SCENE}/", "/nothing", FEED])
@pytest.mark.parametrize("headers", [{"Host": "evil.example"}, {"Origin": "http://evil.example"}])
def test_under_another_name_or_from_another_page_every_path_is_forbidden(
    served: Served, path: str, headers: dict[str, str]
) -> None:
    assert served.get(f"{path}?token={served.token}", **headers)[0] == 403


@pytest.mark.parametrize("path", [FEED, SCENE])
@pytest.mark.parametrize(
    "given",
    [{"token": ""}, {"token": "x"}, {"Origin": "http://evil.example"}, {"Origin": "http://127.0.0.1:1"}],
)
def test_without_token_or_from_another_page_or_port_no_websocket_is_opened(
    served: Served, path: str, given: dict[str, Any]
) -> None:
    with pytest.raises(InvalidStatus) as refused, served.connect(path, **given):
        pass
    assert refused.value.response.status_code == 403


def test_a_cookie_is_neither_set_nor_taken(served: Served) -> None:
    name = f"graphrun_{served.server.port}"
    with pytest.raises(InvalidStatus), served.connect(token="", Cookie=f"{name}={served.token}; token={served.token}"):
        pass


UPGRADE = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
UPGRADE += b"Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n"
STRANGE = {
    "another address": b"GET //[ HTTP/1.1\r\nHost: HOST\r\nHost: HOST\r\n\r\n",
    "a doubled host": b"GET /feed?token=TOKEN HTTP/1.1\r\nHost: HOST\r\nHost: HOST\r\n" + UPGRADE + b"\r\n",
    "a doubled origin": b"GET /feed?token=TOKEN HTTP/1.1\r\nHost: HOST\r\n"
    + 2 * b"Origin: http://HOST\r\n"
    + UPGRADE
    + b"\r\n",
    "doubled cookies": b"GET /feed HTTP/1.1\r\nHost: HOST\r\nCookie: a=1\r\nCookie: token=TOKEN\r\n"
    + UPGRADE
    + b"\r\n",
    "bytes above 127 in the token": b"GET /feed?token=\xff\xfe\xc3\xbc HTTP/1.1\r\nHost: HOST\r\n" + UPGRADE + b"\r\n",
    "bytes above 127 in the host": b"GET / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
    "an upgrade of a file": b"GET /3d/../feed HTTP/1.1\r\nHost: x\r\nUpgrade: a\r\nUpgrade: b\r\n\r\n",
}


@pytest.mark.parametrize("request_of", STRANGE)
def test_a_malformed_request_is_forbidden_and_nothing_is_logged(
    served: Served, request_of: str, caplog: pytest.LogCaptureFixture
) -> None:
    given = STRANGE[request_of].replace(b"HOST", served.host.encode()).replace(b"TOKEN", served.token.encode())
    assert served.send(given) == b"HTTP/1.1 403 Forbidden\r\n"
    assert [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")] == []


@pytest.mark.parametrize("encoding", [b"gzip", b"br, gzip", b"\xff", b"gzip\r\nAccept-Encoding: gzip\r\nUpgrade: x"])
def test_the_3d_part_is_sent_whatever_the_other_headers_are(served: Served, encoding: bytes) -> None:
    request = b"GET /3d/ HTTP/1.1\r\nHost: %s\r\nAccept-Encoding: %s\r\nUpgrade: websocket\r\n\r\n"
    assert served.send(request % (served.host.encode(), encoding)) == b"HTTP/1.1 200 OK\r\n"


def token_of(host: str, port: int, *, keep: bool) -> str:
    with closing(PageServer(host, port, lambda viewer, message: None, dict, keep)) as server:
        return server.url.partition("#token=")[2]


def test_only_a_page_on_loopback_that_may_keep_its_token_has_that_of_the_last_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with socket.create_server(("127.0.0.1", 0)) as unused:
        port = unused.getsockname()[1]
    token = token_of("127.0.0.1", port, keep=True)
    assert token_of("127.0.0.1", port, keep=True) == token
    assert token_of("127.0.0.1", port, keep=False) != token
    assert token_of("0.0.0.0", port, keep=True) != token
    assert token_of("127.0.0.1", port, keep=True) == token


@pytest.mark.parametrize("port", [65536, 70000, -1, 10**30])
def test_a_port_that_does_not_exist_is_an_error(port: int) -> None:
    with pytest.raises(UsageError, match=f"the page cannot be served on port {port}: ports are numbers from 0"):
        PageServer("127.0.0.1", port, lambda viewer, message: None, dict)


@pytest.mark.parametrize(("size", "taken"), [(MAX_REQUEST, True), (MAX_REQUEST + 1, False)])
def test_a_request_that_is_too_long_is_refused_with_an_answer(served: Served, size: int, taken: bool) -> None:
    with served.connect() as viewer:
        viewer.recv(timeout=10)
        text = '{"ask": "command", "id": 7, "fill": "FILL"}'
        viewer.send(text.replace("FILL", "x" * (size - len(text) + len("FILL"))))
        if not taken:
            (answer,) = json.loads(viewer.recv(timeout=10)).values()
            error = f"the request is too long: {size} characters; at most {MAX_REQUEST} are accepted"
            assert answer == {"id": 7, "error": error}
        viewer.send('{"ask": "look"}')
        assert eventually(lambda: {"ask": "look"} in served.asked)
    assert [asked["id"] for asked in served.asked if asked["ask"] == "command"] == ([7] if taken else [])


def test_files_outside_of_the_page_are_not_served(served: Served) -> None:
    for path in ("/../pyproject.toml", f"{SCENE}/../../server.py", f"{SCENE}/%2e%2e/%2e%2e/server.py", "/guard.py"):
        assert served.get(path)[0] == 404


def test_a_viewer_is_greeted_and_heard_and_its_leaving_is_told(served: Served) -> None:
    with served.connect() as viewer:
        assert json.loads(viewer.recv(timeout=10)) == {"stage": {}}
        viewer.send('{"ask": "look", "graph": "a"}')
        assert eventually(lambda: {"ask": "look", "graph": "a"} in served.asked)
    assert eventually(lambda: served.asked[-1] == {"ask": "gone"})


@pytest.mark.parametrize("text", ["no JSON", "[1]", "7", "[" * 900_000, "x" * (MAX_MESSAGE + 1)])
def test_who_sends_anything_else_is_disconnected(served: Served, text: str) -> None:
    with served.connect() as viewer:
        viewer.send(text)
        assert eventually(lambda: {"ask": "gone"} in served.asked)
    assert [asked for asked in served.asked if asked["ask"] not in ("come", "gone")] == []


def test_there_are_no_more_viewers_than_allowed(served: Served) -> None:
    with ExitStack() as viewers:
        for _ in range(MAX_VIEWERS):
            viewers.enter_context(served.connect()).recv(timeout=10)
            viewers.enter_context(served.connect(SCENE)).recv(timeout=10)
        with served.connect() as refused, pytest.raises(ConnectionClosed):
            refused.recv(timeout=10)
    with served.connect() as viewer:
        assert viewer.recv(timeout=10)


def test_of_what_a_viewer_does_not_read_only_the_newest_waits(served: Served) -> None:
    with served.connect() as viewer:
        viewer.recv(timeout=10)
        for number in range(2000):
            served.server.broadcast("frame", json.dumps({"frame": number, "filler": "x" * 10_000}))
        read = [json.loads(viewer.recv(timeout=10))["frame"]]
        while read[-1] != 1999:
            read.append(json.loads(viewer.recv(timeout=10))["frame"])
    assert read == sorted(read)
    assert len(read) < 2000


def test_a_viewer_that_does_not_read_its_answers_is_disconnected(served: Served) -> None:
    with served.connect() as viewer:
        viewer.recv(timeout=10)
        (number,) = served.server.viewers
        for _ in range(300):
            served.server.answer(number, "x" * 100_000)
        assert eventually(lambda: {"ask": "gone"} in served.asked)
        assert not served.server.viewers


def test_the_thread_that_draws_wakes_the_server_s_thread_while_that_begins_and_ends_to_wait(served: Served) -> None:
    queue = served.server.viser._websock_server._broadcast_buffer

    async def wait_anew() -> None:
        queue.message_event.clear()
        await queue.message_event.wait()

    async def wait_again_and_again() -> None:
        for _ in range(300):
            waiting = [asyncio.ensure_future(wait_anew()) for _ in range(100)]
            await asyncio.sleep(0)
            for one in waiting:
                one.cancel()
            await asyncio.gather(*waiting, return_exceptions=True)

    async def wait() -> bool:
        return await queue.message_event.wait()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)  # s
    try:
        waited = asyncio.run_coroutine_threadsafe(wait_again_and_again(), queue.event_loop)
        while not waited.done():
            queue.message_event.set()
        waited.result()
    finally:
        sys.setswitchinterval(interval)
    queue.event_loop.call_soon_threadsafe(queue.message_event.clear)
    woken = asyncio.run_coroutine_threadsafe(wait(), queue.event_loop)
    served.server.viser.scene.add_frame("/new")
    assert woken.result(timeout=10)


def test_nobody_can_ask_for_a_public_tunnel(served: Served) -> None:
    handlers = served.server.viser._websock_server._incoming_handlers
    assert _messages.ShareUrlRequest not in handlers
    assert _messages.ShareUrlDisconnect not in handlers


def test_there_is_one_port_on_the_given_address_and_no_other_user_gets_in(served: Served) -> None:
    listening = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines() if line.split()[3] == "0A"]
    sockets = {os.readlink(entry) for entry in Path("/proc/self/fd").iterdir() if entry.is_symlink()}
    own = [address for _, address, *_, inode in (entry[:10] for entry in listening) if f"socket:[{inode}]" in sockets]
    assert own == [f"0100007F:{served.server.port:04X}"]
    if os.geteuid() == 0:
        stranger = subprocess.run(
            [sys.executable, "-I", "-c", STRANGER, str(served.server.port)], capture_output=True, check=True
        )
        assert stranger.stdout == b"HTTP/1.1 403 Forbidden\n"
