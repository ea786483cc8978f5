"""Listens on a socket through which other programs of the same user send commands to a session.

Each request is one line of JSON, such as `{"command": "push", "arguments": {...}}`. Each response is one line of JSON, either
`{"result": ...}` or `{"error": "reason"}`. A connection can carry any number of requests, one after the other; an invalid request
closes the connection. If a client connects while there are `MAX_CLIENTS` clients, the client that has been idle longest gets an
error with the reason, and is disconnected.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graphengine.control import runs
from graphengine.control.lines import MAX_REQUEST, BadLineError, Lines
from graphengine.format.closing import Closing
from graphengine.format.errors import ControlError, GraphError
from graphengine.format.runtime_folder import folder
from graphengine.runtime.command_queue import CommandQueue

MAX_CLIENTS = 32
"""Maximum number of programs that control a run at the same time."""
ENDING = 1.0
"""Maximum time to wait, when the channel closes, until a client has received its last response, s."""


class Channel(Closing):
    """Accepts clients on a socket, and executes their commands, until the channel is closed.

    Args:
        queue: command queue of the session.
        name: name of the run.
        environment: environment variables; XDG_RUNTIME_DIR determines the folder of the socket.

    Raises:
        ControlError: the socket cannot be created.
    """

    def __init__(self, queue: CommandQueue, name: str, environment: Mapping[str, str]) -> None:
        self._queue = queue
        self._clients: dict[threading.Thread, socket.socket] = {}
        self._idle: dict[threading.Thread, None] = {}
        """Clients without a request in progress; the client that has been idle longest is first."""
        self._lock = threading.Lock()
        self._closed = threading.Event()
        runs.running(environment)  # removes the sockets that killed runs have left behind
        place = folder(environment)
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
        """Bind the socket to the path `unborn`, listen, then rename the path to `self.path`.

        Without this order, another process could remove the socket: a socket that has its final name must listen.
        """
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
            except OSError:  # the socket was closed, or this process cannot open more files at the moment
                self._closed.wait(0.1)
                continue
            with self._lock:
                if not _is_own(connection) or not self._has_room():
                    _refuse(connection, f"{MAX_CLIENTS} clients are waiting for responses; try again later")
                    connection.close()
                    continue
                thread = threading.Thread(target=self._talk, args=(connection,), name="control client", daemon=True)
                try:
                    thread.start()
                except RuntimeError as error:  # such as too many threads
                    _refuse(connection, str(error))
                    connection.close()
                    continue
                self._clients[thread] = connection
                self._idle[thread] = None

    def _has_room(self) -> bool:
        """Return whether another client may connect; if there are too many, disconnect the client that has been idle longest."""
        if len(self._clients) < MAX_CLIENTS:
            return True
        if not self._idle:
            return False
        idlest = next(iter(self._idle))
        del self._idle[idlest]
        connection = self._clients.pop(idlest)
        why = f"this client was idle the longest, and there are more than {MAX_CLIENTS} clients"
        _refuse(connection, f"disconnected: {why}")
        with contextlib.suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)
        return True

    def _talk(self, connection: socket.socket) -> None:
        """Answer the requests of a client until the client disconnects or sends an invalid request."""
        lines, thread = Lines(connection), threading.current_thread()
        try:
            with connection:
                while (request := lines.receive(MAX_REQUEST)) is not None:
                    with self._lock:
                        if thread not in self._idle:  # the client was disconnected meanwhile
                            return
                        del self._idle[thread]
                    lines.send(self._answer(request))
                    with self._lock:
                        self._idle[thread] = None
        except (BadLineError, OSError):
            pass
        finally:
            with self._lock:
                self._idle.pop(thread, None)
                self._clients.pop(thread, None)

    def _answer(self, request: Any) -> dict[str, Any]:
        known = isinstance(request, dict) and isinstance(request.get("command"), str)
        arguments = request.get("arguments", {}) if known else None
        if not known or not isinstance(arguments, dict) or set(request) - {"command", "arguments"}:
            raise BadLineError
        try:
            return {"result": self._queue.submit(request["command"], arguments).result()}
        except GraphError as error:
            return {"error": str(error)}
        except Exception as error:
            return {"error": f"{type(error).__name__}: {error}"}

    def close(self) -> None:
        """Send outstanding responses, disconnect all clients and remove the socket. Safe to call twice."""
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


def _refuse(connection: socket.socket, why: str) -> None:
    """Send a client the reason for its disconnection, if possible without waiting."""
    with contextlib.suppress(OSError):
        connection.send(json.dumps({"error": why}).encode() + b"\n", socket.MSG_DONTWAIT)


def _is_own(connection: socket.socket) -> bool:
    """Return whether a client runs as the same user.

    Return True on systems without SO_PEERCRED, where only the mode of the folder protects the socket.
    """
    if not hasattr(socket, "SO_PEERCRED"):
        return True
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    _, user, _ = struct.unpack("3i", credentials)
    return bool(user == os.getuid())
