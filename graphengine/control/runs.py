"""The running sessions of this user on this machine: each has a socket in a folder that is nobody else's.

A socket is named `NAME.PID`, after the file that is run and its process. One that nobody listens to was left by a process that
was killed, and is removed by whoever looks next.
"""

from __future__ import annotations

import contextlib
import os
import re
import socket
import stat
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from graphengine.format.errors import ControlError

_ENTRY = re.compile(r"([A-Za-z0-9_]+)\.([0-9]+)")
MAX_NAME = 40
"""Characters of a run's name: the path of a socket has at most 107."""
RUNTIME = "/run/user"
"""Where systemd keeps what XDG_RUNTIME_DIR names; `su`, cron and some shells leave the variable out, and meant is the same."""
PATIENCE = 5.0
"""Seconds in which a run that is there lets others connect."""


@dataclass(frozen=True, slots=True, order=True)
class Entry:
    """A run that can be reached."""

    name: str
    pid: int
    path: Path

    def __str__(self) -> str:
        return f"{self.name} (process {self.pid})"


def folder(environment: Mapping[str, str]) -> Path:
    """The folder of the sockets, made if it is not there.

    Raises:
        ControlError: it cannot be made, or others than the user could write to it.
    """
    named, usual = environment.get("XDG_RUNTIME_DIR", ""), f"{RUNTIME}/{os.getuid()}"
    runtime = next((path for path in (named, usual) if os.path.isabs(path) and os.path.isdir(path)), None)
    path = Path(runtime, "graphrun") if runtime else Path(tempfile.gettempdir(), f"graphrun-{os.getuid()}")
    try:
        with contextlib.suppress(FileExistsError):
            path.mkdir(mode=0o700)
        found = path.lstat()
    except OSError as error:
        raise ControlError(f"{path}: {error.strerror}") from None
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise ControlError(f"{path}: not a folder that is the user's alone, with mode 700")
    return path


def entry_name(name: str, pid: int) -> str:
    """What the socket of a run is called."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:MAX_NAME] or "run"
    return f"{plain}.{pid}"


def connect(path: Path) -> socket.socket:
    """A connection to a run.

    Raises:
        OSError: nobody is there; ConnectionRefusedError when nobody is any more.
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
    """The runs that can be reached, by name; what dead ones left behind is removed.

    Raises:
        ControlError: the folder of the sockets is not the user's alone.
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
            pass  # it is too busy to answer, and there
        found.append(Entry(match[1], int(match[2]), path))
    return sorted(found)
