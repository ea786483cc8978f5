"""The socket by which other programs of the same user reach a session's desk.

Each request is a line of JSON, `{"command": "push", "arguments": {...}}`, and is answered by one: `{"result": ...}`, or
`{"error": "why not"}`. A connection may carry any number of them, one after the other. Who sends anything else is disconnected.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graphengine.control import runs
from graphengine.control.desk import CommandDesk
from graphengine.control.lines import MAX_REQUEST, BadLineError, Lines
from graphengine.diagnostics import ControlError, GraphError

MAX_CLIENTS = 32
ENDING = 1.0
"""Seconds that clients get to hear the last answers."""


class Channel:
    """Listens from when it is made until it is closed.

    Args:
        desk: of the session.
        name: of the run.
        environment: where the folder of the sockets is found.

    Raises:
        ControlError: there is no place for the socket.
    """

    def __init__(self, desk: CommandDesk, name: str, environment: Mapping[str, str]) -> None:
        self._desk = desk
        self._clients: dict[threading.Thread, socket.socket] = {}
        self._lock = threading.Lock()
        self._closed = threading.Event()
        runs.running(environment)  # which clears away what killed ones have left
        place = runs.folder(environment)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.path = place / runs.entry_name(name, os.getpid())
        try:
            self._listen(place / f".{os.getpid()}")
        except OSError as error:
            self._socket.close()
            raise ControlError(f"{self.path}: {error.strerror or error}") from None
        self._thread = threading.Thread(target=self._accept, name="control", daemon=True)
        self._thread.start()

    def _listen(self, unborn: Path) -> None:
        """A socket gets its name when it listens: before, it would look like one that was left behind."""
        with contextlib.suppress(FileNotFoundError):
            unborn.unlink()
        self._socket.bind(str(unborn))
        try:
            self._socket.listen(MAX_CLIENTS)
            unborn.rename(self.path)
        except BaseException:
            unborn.unlink()
            raise

    def _accept(self) -> None:
        while not self._closed.is_set():
            try:
                connection, _ = self._socket.accept()
            except OSError:  # it was closed, or this process may open no more files for now
                self._closed.wait(0.1)
                continue
            with self._lock:
                if len(self._clients) >= MAX_CLIENTS or not _is_own(connection):
                    connection.close()
                    continue
                thread = threading.Thread(target=self._talk, args=(connection,), name="control client", daemon=True)
                self._clients[thread] = connection
                thread.start()

    def _talk(self, connection: socket.socket) -> None:
        """Answer a client until it has had enough."""
        lines = Lines(connection)
        try:
            with connection:
                while (request := lines.receive(MAX_REQUEST)) is not None:
                    lines.send(self._answer(request))
        except (BadLineError, OSError):
            pass
        finally:
            with self._lock:
                self._clients.pop(threading.current_thread(), None)

    def _answer(self, request: Any) -> dict[str, Any]:
        known = isinstance(request, dict) and isinstance(request.get("command"), str)
        arguments = request.get("arguments", {}) if known else None
        if not known or not isinstance(arguments, dict) or set(request) - {"command", "arguments"}:
            raise BadLineError
        try:
            return {"result": self._desk.submit(request["command"], arguments).result()}
        except GraphError as error:
            return {"error": str(error)}
        except Exception as error:
            return {"error": f"{type(error).__name__}: {error}"}

    def close(self) -> None:
        """Let clients hear the answers that are due, and leave nothing behind; safe to call twice."""
        self._closed.set()
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # ends `accept`
        self._socket.close()
        self._thread.join(ENDING)
        with self._lock:
            clients = dict(self._clients)
        for connection in clients.values():
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RD)
        for thread in clients:
            thread.join(ENDING)

    def __enter__(self) -> Channel:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _is_own(connection: socket.socket) -> bool:
    """Whether a client is the same user's, where the system tells; elsewhere the folder's mode has to do."""
    if not hasattr(socket, "SO_PEERCRED"):
        return True
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    _, user, _ = struct.unpack("3i", credentials)
    return bool(user == os.getuid())
