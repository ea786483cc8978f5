"""Finds the folder for sockets and tokens of this user's runs, which no other user can access."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from graphengine.format.errors import ControlError

RUNTIME = "/run/user"
"""Parent of systemd's runtime folders, for processes without XDG_RUNTIME_DIR, such as those of `su` and cron."""


def folder(environment: Mapping[str, str]) -> Path:
    """Return the folder; create it if it does not exist.

    Raises:
        ControlError: the folder cannot be created, or other users can access it.
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
        raise ControlError(f"{path}: must be a folder that you own, with mode 700")
    return path
