"""Watches the files of a session and asks for a reload when they change."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Self

from graphengine.format.files import Signature, signature
from graphengine.runtime.command_queue import Desk
from graphengine.runtime.reloading import Reloader

PERIOD = 0.05
"""Seconds of wall time between two looks at the files. A change takes effect once two looks see the same, as it is written then."""


class FileWatch:
    """A thread that looks at the files of a session, also at those that a graph names and that are not there yet.

    Files are looked at, not directories: editors that write in place, and those that put another file in the place of the old
    one, are seen alike, on file systems without notifications too.

    Args:
        reloader: of the session; it knows the files.
        desk: where the reload is asked for.
        report: called in the session's thread with the future of each reload.
    """

    def __init__(self, reloader: Reloader, desk: Desk, report: Callable[[Future[Any]], None]) -> None:
        self._reloader = reloader
        self._desk = desk
        self._report = report
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="file watch", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        handled: Mapping[Path, Signature] = {}
        before: Mapping[Path, Signature] = {}
        while not self._ended.wait(PERIOD):
            noted = self._reloader.watched()
            now = {path: signature(path) for path in noted}
            if all(there in (noted[path], handled.get(path, noted[path])) for path, there in now.items()):
                continue
            if now != before:
                before = now
                continue
            handled = now
            done = self._desk.submit("reload")
            done.add_done_callback(self._report)
            while not done.done() and not self._ended.wait(PERIOD):
                pass

    def close(self) -> None:
        """End the thread; safe to call twice."""
        self._ended.set()
        self._thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
