"""Keeps the token of a page between runs on the same port, so that open tabs connect to the next run by themselves."""

from __future__ import annotations

import contextlib
import os
import re
import stat
import time
from collections.abc import Mapping
from pathlib import Path

from graphengine.format.errors import ControlError
from graphengine.format.runtime_folder import folder
from graphengine.format.web_access import make_token

LONGEST_PAUSE = 86_400.0
"""Maximum time between the starts of two runs with the same token, s."""
_TOKEN = re.compile(rb"[A-Za-z0-9_-]{32}")


def kept_token(port: int, environment: Mapping[str, str]) -> str:
    """Return the token of the last run on a port; a new one without such a run, and for port 0, which is another port each time.

    The token is in a file that only this user can access. A file that others could have written or read is replaced.

    Args:
        port: TCP port that the user chose; 0 for a free port.
        environment: environment variables; XDG_RUNTIME_DIR determines the folder of the file.
    """
    token = make_token()
    if port == 0:
        return token
    try:
        path = folder(environment) / f"page-{port}.token"
    except ControlError:
        return token
    if kept := _read(path):
        with contextlib.suppress(OSError):
            os.utime(path)
        return kept
    with contextlib.suppress(OSError):
        path.unlink(missing_ok=True)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        with open(descriptor, "wb") as file:
            file.write(token.encode())
    return token


def _read(path: Path) -> str:
    """Return the token in a file; empty if there is none, if it is too old, or if others can access it."""
    try:
        if not stat.S_ISREG(os.lstat(path).st_mode):
            return ""
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return ""
    with open(descriptor, "rb") as file:
        found = os.fstat(file.fileno())
        own = stat.S_ISREG(found.st_mode) and found.st_uid == os.getuid() and found.st_nlink == 1
        if not own or found.st_mode & 0o077 or not 0 <= time.time() - found.st_mtime <= LONGEST_PAUSE:
            return ""
        text = file.read(100)
        return text.decode() if _TOKEN.fullmatch(text) else ""
