"""ROS domains for runs at the same time on one machine: each run gets one that no other run has."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graphengine.format.errors import TransportError

FIRST, LAST = 1, 101
"""Domains that runs get; their ports lie below those that Linux gives to other programs, up to 101."""
LOCAL = "ROS_AUTOMATIC_DISCOVERY_RANGE"


@contextmanager
def free_domain() -> Iterator[int]:
    """Return a ROS domain that no other run of this user has; a lock file holds it until the end.

    Runs of two machines may have the same domain. So until the end, ROS in this process, and in programs that it starts, finds
    only programs of this machine, unless the user has set LOCAL or its predecessor. The user's own ROS_DOMAIN_ID is not returned.

    Raises:
        TransportError: all domains are taken.
    """
    import fcntl

    folder = _folder()
    used = os.environ.get("ROS_DOMAIN_ID", "").strip()
    for number in range(FIRST, LAST + 1):
        if str(number) == used:
            continue
        handle = os.open(folder / f"domain-{number}", os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            continue
        try:
            with _on_this_machine():
                yield number
        finally:
            os.close(handle)
        return
    raise TransportError(f"the ROS domains {FIRST} to {LAST} are all taken by other runs; wait until one ends")


@contextmanager
def _on_this_machine() -> Iterator[None]:
    if LOCAL in os.environ or "ROS_LOCALHOST_ONLY" in os.environ:
        yield
        return
    os.environ[LOCAL] = "LOCALHOST"
    try:
        yield
    finally:
        os.environ.pop(LOCAL, None)


def _folder() -> Path:
    """Return the folder of the lock files, which only this user can write to."""
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    folder = Path(base, f"graphengine-domains-{os.getuid()}")
    folder.mkdir(mode=0o700, exist_ok=True)
    state = folder.lstat()
    if state.st_uid != os.getuid() or state.st_mode & 0o022:
        raise TransportError(f"{folder}: belongs to another user, or others can write to it; remove it")
    return folder
