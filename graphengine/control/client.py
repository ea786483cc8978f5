"""A client that controls a running session from another program of the same user."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping
from typing import Any

from graphengine.control import runs
from graphengine.control.lines import MAX_ANSWER, BadLineError, Lines
from graphengine.control.runs import Entry
from graphengine.format.closing import Closing
from graphengine.format.errors import ControlError, UsageError
from graphengine.format.runtime_folder import folder
from graphengine.format.wording import did_you_mean


class Client(Closing):
    """A connection to a run.

    Args:
        entry: run to connect to.
        patience: maximum wall time until a response begins, s; None means no limit. Close the client after a timeout: otherwise
            the next request would get the late response.

    Raises:
        ControlError: the run does not accept the connection, for example because the run has ended.
    """

    def __init__(self, entry: Entry, patience: float | None = None) -> None:
        self.entry = entry
        self._patience = patience
        try:
            self._connection = runs.connect(entry.path)
        except OSError as error:
            raise ControlError(f"{entry} does not answer: {error.strerror or error}") from None
        self._lines = Lines(self._connection)

    def ask(self, command: str, arguments: Mapping[str, Any] | None = None) -> Any:
        """Send a command and return its result; `commands.COMMANDS` lists the commands.

        Raises:
            ControlError: the run rejected the command, ended before the response, or did not answer in time.
        """
        try:
            # A refused client can still read the reason.
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                self._lines.send({"command": command, "arguments": dict(arguments or {})})
            answer = self._lines.receive(MAX_ANSWER, patience=self._patience)
        except BadLineError:
            if self._patience is not None:
                raise ControlError(f"{self.entry} did not answer within {self._patience:g} s") from None
            answer = None
        except OSError:
            answer = None
        if not isinstance(answer, dict):
            raise ControlError(f"{self.entry} ended before it answered")
        if "error" in answer:
            raise ControlError(str(answer["error"]))
        return answer.get("result")

    def interrupt(self) -> None:
        """Shut down the connection; an `ask` in progress raises ControlError. Another thread may call this method."""
        with contextlib.suppress(OSError):  # the run has already closed the connection
            self._connection.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the connection; the run continues."""
        self._connection.close()


def find(meant: str = "", environment: Mapping[str, str] = os.environ) -> Entry:
    """Return the run whose name or process id is `meant`; if `meant` is empty, the only run.

    Raises:
        ControlError: no run matches.
        UsageError: several runs match.
    """
    there = runs.running(environment)
    fitting = [entry for entry in there if meant in ("", entry.name, str(entry.pid))]
    if len(fitting) == 1:
        return fitting[0]
    if not there:
        remedy = "start one, for example: graphrun run dd100_warehouse"
        raise ControlError(f"no run to control\n  {remedy}\n  looked in {folder(environment)}")
    listed = "".join(f"\n  --run {entry.pid}   {entry.name}" for entry in fitting or there)
    if fitting:
        raise UsageError(f"there are {len(fitting)} runs; choose one{listed}")
    near = did_you_mean(meant, [entry.name for entry in there])
    raise ControlError(f"there is no run {meant!r}{'; ' + near if near else ''}{listed}")
