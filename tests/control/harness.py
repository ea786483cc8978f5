"""A session that runs in a thread of its own, and is asked for things from this one."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.session_core import SessionCore
from tests.waiting import PATIENCE


class Controlled:
    """A run of a session, from outside of its thread."""

    def __init__(self, session: SessionCore, **how: Any) -> None:
        self.session = session
        self.queue = session.queue = CommandQueue()
        self.error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, kwargs=how)
        self._thread.start()

    def _run(self, **how: Any) -> None:
        try:
            with self.session:
                self.session.run(**how)
        except BaseException as error:
            self.error = error

    def ask(self, name: str, /, **arguments: Any) -> Any:
        """Ask for something, and wait for what comes of it."""
        return self.queue.submit(name, arguments).result(PATIENCE)

    def end(self) -> None:
        """Wait until the run has ended."""
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()


@contextlib.contextmanager
def controlled(session: SessionCore, **how: Any) -> Iterator[Controlled]:
    run = Controlled(session, **how)
    try:
        yield run
    finally:
        session.interrupt()
        run.end()
