"""The run's side of its page: starts the page's process, and sends the state of the run to it without blocking."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import socket
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from typing import Any

from graphengine.format.errors import UsageError
from graphengine.format.wording import printable

ALLOWED = 120.0
"""Maximum wall time for which `wait` waits, s."""
FAREWELL = 1.0
"""Maximum wall time for which `close` waits for data to be sent, s."""
LAST_LINES, LONGEST_LINE = 5, 300
"""Number of the newest lines of the process's output to keep, and maximum length of a line, bytes."""

_log = logging.getLogger(__name__)


class Page:
    """The process of a page, with a thread that writes to it, one that reads from it, and one that reads its output.

    The constructor does not wait for the process, which takes seconds to start, and on a busy machine much longer. Objects wait
    in a queue and are sent in order; of the waiting frames, only the newest one is kept. What the process and the packages in it
    print never reaches the terminal as it is: it goes, without control characters, to the debug messages of a logger, and its
    last lines are part of `failure`.

    Args:
        host: IP address on which to serve the page.
        port: TCP port of the page; 0 selects a free port.
        asked: called with each request of a viewer, in the reading thread.
        keep_token: whether runs on this port have the same token.
    """

    def __init__(
        self, host: str, port: int, asked: Callable[[Mapping[str, Any]], None], keep_token: bool = False
    ) -> None:
        ours, theirs = socket.socketpair()
        try:
            # Without the working directory among its modules: a file there may be a stranger's.
            module, token = f"{__package__}.page_process", "keep" if keep_token else "new"
            command = [sys.executable, "-P", "-m", module, str(theirs.fileno()), host, str(port), token]
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            self._process = subprocess.Popen(
                command,
                env=environment,
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
        finally:
            theirs.close()
        self._socket, self._connection = ours, Connection(os.dup(ours.fileno()))
        self._asked = asked
        self._closed = False
        self._known = threading.Event()
        """Set as soon as `url` or `failure` is known."""
        self.url = ""
        """URL of the page; empty until the page can be opened."""
        self.failure = ""
        """Why the process ended before `close` was called; empty until then."""
        self._news = threading.Condition()
        self._waiting: list[object] = []
        self._frame: object = None
        self._output: deque[str] = deque(maxlen=LAST_LINES)
        jobs = (self._write, self._read, self._read_output)
        self._threads = [threading.Thread(target=job, name="page", daemon=True) for job in jobs]
        for thread in self._threads:
            thread.start()

    @property
    def lost(self) -> bool:
        """Whether the process ended before `close` was called."""
        return bool(self.failure)

    def wait(self) -> str:
        """Wait until the page can be opened, and return its URL.

        Raises:
            UsageError: the page cannot be served, or its process does not serve it within `ALLOWED` s.
        """
        served = self._known.wait(ALLOWED)
        if self.failure or not served:
            raise UsageError(self.failure or f"the process of the page did not start within {ALLOWED:g} s")
        return self.url

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
            except OSError:  # which the reading thread finds too
                return
            with self._news:
                if self._frame is told[-1]:
                    self._frame = None

    def _read(self) -> None:
        why = ""
        with contextlib.suppress(EOFError, OSError):
            why = self._read_start()
            while not why:
                self._asked(json.loads(self._connection.recv_bytes()))
        if not self._closed:
            self._threads[2].join(FAREWELL)
            self.failure = why or "\n  ".join(["the process of the page has ended", *self._output])
        self._known.set()

    def _read_start(self) -> str:
        """Wait until the process serves the page; return an empty text, or the reason why the page cannot be served."""
        told = json.loads(self._connection.recv_bytes())
        self.url = told.get("url", "")
        if self.url:
            self._known.set()
        return str(told.get("error", ""))

    def _read_output(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as output:
            while line := output.readline(LONGEST_LINE):
                self._output.append(printable(line.decode(errors="replace").rstrip()))
                _log.debug("%s", self._output[-1])

    def close(self, last: object = None) -> None:
        """Send the waiting objects and then `last`, and end the process; safe to call twice."""
        with self._news:
            self._waiting += [one for one in (self._frame, last) if one is not None and not self._closed]
            self._frame = None
            self._closed = True
            self._news.notify_all()
        writer, reader, output = self._threads
        if self.url:  # a process that still starts has no viewers
            writer.join(FAREWELL)
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # which wakes the first two threads
        self._socket.close()
        try:
            self._process.wait(5.0 if self.url else 0.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        writer.join()
        reader.join()
        output.join(FAREWELL)
        self._connection.close()
