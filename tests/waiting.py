"""What tests of processes and networks share: domains of their own, and waiting for what comes in its own time."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

PATIENCE = 100.0  # s; what is waited for comes within a second or two on an idle machine, a loaded one took 50
DOMAINS = range(101, 200)
"""ROS 2 domains for tests, above those that people use."""

_numbers = itertools.count(os.getpid())


def eventually(condition: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> bool:
    """Wait until a condition holds, and do something else meanwhile; False when it never does."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            return False
        meanwhile()
        time.sleep(0.005)
    return True


@contextlib.contextmanager
def reserved_domain() -> Iterator[int]:
    """A domain that no other test on this machine is in; the lock of a file keeps tests of other processes out of it."""
    for number in itertools.islice(_numbers, len(DOMAINS)):
        domain_id = DOMAINS[number % len(DOMAINS)]
        path = Path(tempfile.gettempdir(), f"graphengine-tests-{os.getuid()}-domain-{domain_id}")
        with path.open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain_id
            return
    raise RuntimeError("tests of other processes are in all domains")
