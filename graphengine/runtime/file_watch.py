"""Watches the files of a session, and submits the command `reload` when they change."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from graphengine.format.closing import Closing
from graphengine.format.files import Signature, signature
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.reloading import Reloader

MOST = 0.05
"""Maximum fraction of wall time for checks of the files; the thread sleeps for the rest."""
PERIOD = 0.05
"""Minimum wall time between two checks of the files, s; two successive checks with the same change submit a reload."""


class FileWatch(Closing):
    """A thread that watches the files of a session, and the paths of missing files.

    The thread polls inodes, sizes and times instead of using notifications. So it detects editors that replace a file as well as
    editors that write in place, works on network file systems, and needs no handle for each directory.

    Args:
        reloader: lists the files of the session.
        queue: queue to which the command `reload` is submitted.
        report: called in the session's thread with the completed future of each reload.
    """

    def __init__(self, reloader: Reloader, queue: CommandQueue, report: Callable[[Future[Any]], None]) -> None:
        self._reloader = reloader
        self._queue = queue
        self._report = report
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="file watch", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        handled: Mapping[Path, Signature] = {}
        before: Mapping[Path, Signature] = {}
        took = 0.0
        while not self._ended.wait(max(PERIOD, took / MOST)):
            begun, noted = time.perf_counter(), self._reloader.watched()
            now = {path: signature(path) for path in noted}
            took = time.perf_counter() - begun
            if all(there in (noted[path], handled.get(path, noted[path])) for path, there in now.items()):
                continue
            if now != before:
                before = now
                continue
            handled = now
            done = self._queue.submit("reload")
            done.add_done_callback(self._report)
            while not done.done() and not self._ended.wait(PERIOD):
                pass

    def close(self) -> None:
        """End the thread; safe to call twice."""
        self._ended.set()
        self._thread.join()
