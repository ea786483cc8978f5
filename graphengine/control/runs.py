"""Finds the runs (sessions with a control channel) of this user on this machine.

Each run has a socket in a folder that only the user can access. The file name of the socket is `NAME.PID`, with the name and the
process id of the run. A killed process leaves behind a socket that accepts no connection; `running` removes such sockets.
"""

from __future__ import annotations

import contextlib
import re
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from graphengine.format.runtime_folder import folder

_ENTRY = re.compile(r"([A-Za-z0-9_]+)\.([0-9]+)")
MAX_NAME = 40
"""Maximum length of a run's name in the path of the run's socket; the path can have at most 107 characters."""
PATIENCE = 5.0
"""Timeout for connecting to a run, s."""


@dataclass(frozen=True, slots=True, order=True)
class Entry:
    """A run: its name, process id and path of the socket."""

    name: str
    pid: int
    path: Path

    def __str__(self) -> str:
        return f"{self.name} (process {self.pid})"


def entry_name(name: str, pid: int) -> str:
    """Return the file name of a run's socket."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:MAX_NAME] or "run"
    return f"{plain}.{pid}"


def connect(path: Path) -> socket.socket:
    """Connect to the socket of a run and return the connection.

    Raises:
        OSError: the run cannot be reached; ConnectionRefusedError if the run's process has ended.
    """
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.settimeout(PATIENCE)
        connection.connect(str(path))
        connection.settimeout(None)
    except BaseException:
        connection.close()
        raise
    return connection


def running(environment: Mapping[str, str]) -> list[Entry]:
    """Return the runs that accept connections, sorted by name; remove the sockets of dead processes.

    Raises:
        ControlError: other users can access the folder of the sockets.
    """
    found = []
    for path in sorted(folder(environment).iterdir()):
        match = _ENTRY.fullmatch(path.name)
        if match is None:
            continue
        try:
            connect(path).close()
        except (ConnectionRefusedError, FileNotFoundError):
            with contextlib.suppress(OSError):
                path.unlink()
            continue
        except OSError:
            pass  # the run exists, but is too busy to answer
        found.append(Entry(match[1], int(match[2]), path))
    return sorted(found)
