"""JSON over a stream, one value a line."""

from __future__ import annotations

import json
import socket
import time
from typing import Any

MAX_REQUEST, MAX_ANSWER = 100_000, 10_000_000
"""Bytes of a line."""
PATIENCE = 10.0
"""Seconds that a line which has begun may take to come, and to be taken."""


class BadLineError(Exception):
    """What came is no line of JSON, is too long, or took too long."""


class Lines:
    """The lines of a connection.

    Args:
        connection: a stream; it stays its owner's.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._rest = b""

    def send(self, value: Any) -> None:
        """Send a value.

        Raises:
            OSError: the other end is gone, or takes nothing.
        """
        self._connection.settimeout(PATIENCE)
        self._connection.sendall(json.dumps(value).encode() + b"\n")

    def receive(self, most: int, *, patience: float | None = None) -> Any:
        """The next value, None at the end.

        Args:
            most: bytes that it may have.
            patience: seconds until it begins; None for ever.

        Raises:
            BadLineError: it is none.
            OSError: the other end is gone.
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
            return json.loads(line)
        except (ValueError, RecursionError):
            raise BadLineError from None
