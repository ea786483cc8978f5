"""The run's side of its page: starts the page's process, and sends the state of the run to it without blocking."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

from graphengine.format.errors import UsageError

ALLOWED = 20.0
"""Maximum wait for the page to start, s."""
FAREWELL = 1.0
"""Maximum wall time for which `close` waits for data to be sent, s."""


class Page:
    """The process of a page, with one thread that writes to it and one that reads from it.

    Objects wait in a queue and are sent in order; of the waiting frames, only the newest one is kept.

    Args:
        host: IP address on which to serve the page.
        port: TCP port of the page; 0 selects a free port.
        asked: called with each request of a viewer, in the reading thread.

    Raises:
        UsageError: viser is not installed, or the page cannot be served at this address.
    """

    def __init__(self, host: str, port: int, asked: Callable[[Mapping[str, Any]], None]) -> None:
        ours, theirs = socket.socketpair()
        try:
            # Without the working directory among its modules: a file there may be a stranger's.
            command = [sys.executable, "-P", "-m", f"{__package__}.page_process", str(theirs.fileno()), host, str(port)]
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            self._process = subprocess.Popen(
                command, env=environment, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL
            )
        finally:
            theirs.close()
        self._socket, self._connection = ours, Connection(os.dup(ours.fileno()))
        self._asked = asked
        self._closed = False
        self.lost = False
        """Whether the process ended before `close` was called."""
        self._news = threading.Condition()
        self._waiting: list[object] = []
        self._frame: object = None
        self._threads: list[threading.Thread] = []
        try:
            self.url = self._wait()
        except BaseException:
            self.close()
            raise
        self._threads = [threading.Thread(target=job, name="page", daemon=True) for job in (self._write, self._read)]
        for thread in self._threads:
            thread.start()

    def _wait(self) -> str:
        """Wait until the page's process has started, and return the URL of the page.

        Raises:
            UsageError: the page did not start in time, or its process reports an error.
        """
        told: Mapping[str, str] = {}
        with contextlib.suppress(EOFError, OSError):
            if self._connection.poll(ALLOWED):
                told = json.loads(self._connection.recv_bytes())
        if "url" not in told:
            raise UsageError(
                told.get("error") or "the page did not start: its process failed (see its output) or took too long"
            )
        return told["url"]

    @property
    def process_id(self) -> int:
        """Id of the page's process."""
        return self._process.pid

    @property
    def busy(self) -> bool:
        """Whether a frame is waiting to be written."""
        return self._frame is not None

    def tell(self, told: object) -> None:
        """Queue an object for the page; objects are sent in order."""
        with self._news:
            self._waiting.append(told)
            self._news.notify()

    def show(self, frame: object) -> None:
        """Queue a frame for the page; it replaces a frame that is still waiting."""
        with self._news:
            self._frame = frame
            self._news.notify()

    def _write(self) -> None:
        while True:
            with self._news:
                self._news.wait_for(lambda: self._waiting or self._frame is not None or self._closed)
                told = [*self._waiting, *([self._frame] if self._frame is not None else [])]
                self._waiting.clear()
                if self._closed and not told:
                    return
            try:
                for one in told:
                    self._connection.send(one)
            except OSError:
                self.lost = not self._closed
                return
            with self._news:
                if self._frame is told[-1]:
                    self._frame = None

    def _read(self) -> None:
        with contextlib.suppress(EOFError, OSError):
            while True:
                self._asked(json.loads(self._connection.recv_bytes()))
        self.lost = not self._closed

    def close(self, last: object = None) -> None:
        """Send the waiting objects and then `last`, and end the process; safe to call twice."""
        with self._news:
            self._waiting += [one for one in (self._frame, last) if one is not None and not self._closed]
            self._frame = None
            self._closed = True
            self._news.notify_all()
        for writer in self._threads[:1]:
            writer.join(FAREWELL)
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # which wakes both threads
        self._socket.close()
        for thread in self._threads:
            thread.join()
        self._connection.close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
