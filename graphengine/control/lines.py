"""Sends and receives JSON values over a stream, one value per line."""

from __future__ import annotations

import json
import socket
import time
from typing import Any

from graphengine.format import bounded_json

MAX_REQUEST, MAX_ANSWER = 100_000, 10_000_000
"""Maximum length of a request line and of a response line, bytes."""
PATIENCE = 10.0
"""Timeout for receiving the rest of a line after its first byte, and for sending a line, s."""


class BadLineError(Exception):
    """The received line is not JSON, is too long, or was not complete before the timeout."""


class Lines:
    """Sends and receives JSON lines on a connection.

    Args:
        connection: stream socket; the caller closes it.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._rest = b""

    def send(self, value: Any) -> None:
        """Send a value as one line of JSON.

        Raises:
            OSError: the peer has disconnected, or has not received the line within `PATIENCE` s.
        """
        self._connection.settimeout(PATIENCE)
        self._connection.sendall(json.dumps(value).encode() + b"\n")

    def receive(self, most: int, *, patience: float | None = None) -> Any:
        """Receive a line and return its JSON value; None at the end of the stream.

        Args:
            most: maximum length of the line, bytes.
            patience: maximum time to wait for the first byte of the line, s; None means no limit.

        Raises:
            BadLineError: the line is not JSON, is too long, or was not complete before the timeout.
            OSError: the peer has disconnected.
        """
        deadline = time.monotonic() + PATIENCE if self._rest else None
        while b"\n" not in self._rest:
            left = patience if deadline is None else deadline - time.monotonic()
            if len(self._rest) > most or (left is not None and left <= 0.0):
                raise BadLineError
            self._connection.settimeout(left)
            try:
                more = self._connection.recv(65536)
            except TimeoutError:
                raise BadLineError from None
            if not more:
                return None
            self._rest += more
            deadline = deadline or time.monotonic() + PATIENCE
        line, _, self._rest = self._rest.partition(b"\n")
        if len(line) > most:
            raise BadLineError
        try:
            return bounded_json.parse(line, most)
        except ValueError:
            raise BadLineError from None
