"""Linux system calls for which Python has no function."""

from __future__ import annotations

import ctypes
import os
import resource
import select
import signal
import sys

_NO_NEW_PRIVILEGES, _DUMPABLE, _DEATH_SIGNAL = 38, 4, 1
"""Options PR_SET_NO_NEW_PRIVS, PR_SET_DUMPABLE and PR_SET_PDEATHSIG of prctl(2)."""
_VERSION, _READ_FILES = 0x20080522, 1 << 2
"""Version 3 of the structures of capset(2), and the bit of CAP_DAC_READ_SEARCH, the right to read all files."""


def call(number: int, *arguments: int) -> int:
    """Return the result of a system call; -1 if the call fails, and always on systems other than Linux."""
    if sys.platform != "linux":
        return -1
    function = ctypes.CDLL(None).syscall
    function.restype = ctypes.c_long
    return int(function(*map(ctypes.c_long, (number, *arguments))))


def renounce_privileges() -> None:
    """Drop all capabilities of this thread except reading the files of other users, and prevent the thread from gaining others.

    The process will write no core dump, because a core dump passes its memory to another program. It will be killed when its
    parent ends. It can queue no signals, because the number of queued signals is limited for all processes of a user together.

    Raises:
        OSError: prctl(2) or capset(2) fails.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    for option, value in ((_NO_NEW_PRIVILEGES, 1), (_DUMPABLE, 0), (_DEATH_SIGNAL, signal.SIGKILL)):
        if libc.prctl(option, value, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")
    reader = select.poll()
    reader.register(1, 0)
    if reader.poll(0):  # nobody reads the output any more: the parent ended before this call
        os._exit(1)
    resource.setrlimit(resource.RLIMIT_SIGPENDING, (0, 0))
    header = (ctypes.c_uint32 * 2)(_VERSION, 0)
    sets = (ctypes.c_uint32 * 6)()  # effective, permitted and inheritable set, twice
    if libc.capget(header, sets) == 0:
        kept = (ctypes.c_uint32 * 6)(sets[0] & _READ_FILES, sets[1] & _READ_FILES)
        if libc.capset(header, kept) != 0:
            raise OSError(ctypes.get_errno(), "capset")
