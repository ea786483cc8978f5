"""Landlock: makes the kernel permanently restrict the access of this process to files, TCP and other processes.

Linux has Landlock since 5.13, unless it is disabled at build or boot time. Numbers and structures are those of linux/landlock.h.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterable
from pathlib import Path

from graphengine.sandbox.system_calls import call, renounce_privileges

_CREATE, _ADD, _RESTRICT = 444, 445, 446
"""Numbers of the system calls landlock_create_ruleset, _add_rule and _restrict_self, the same on all architectures."""
_VERSION = 1
"""Flag LANDLOCK_CREATE_RULESET_VERSION: landlock_create_ruleset returns the version of Landlock and creates nothing."""
_BENEATH = 1
_READ_FILE, _READ_FOLDER = 1 << 2, 1 << 3


class _Rules(ctypes.Structure):
    """The kernel's `landlock_ruleset_attr`: bit masks of the operations on files, TCP and other processes to deny by default."""

    _fields_ = (("files", ctypes.c_uint64), ("tcp", ctypes.c_uint64), ("outside", ctypes.c_uint64))


class _Below(ctypes.Structure):
    """The kernel's `landlock_path_beneath_attr`: a rule that allows operations on a file or below a folder."""

    _pack_ = 1
    _layout_ = "ms"  # what `_pack_` has always meant; Python 3.14 warns without it
    _fields_ = (("rights", ctypes.c_uint64), ("folder", ctypes.c_int32))


def available() -> bool:
    """Return whether this kernel has Landlock."""
    return _version() >= 1


def restrict(readable: Iterable[Path]) -> None:
    """Allow this process to read the given files and folders; deny it all other access to files, including starting programs.

    TCP connections are also denied since Linux 6.7, and signals to other processes since 6.12. Open files stay open.

    Raises:
        OSError: the kernel does not accept the restriction.
        RuntimeError: the process has several threads, but Landlock would restrict only one of them.
    """
    if (threads := len(os.listdir("/proc/self/task"))) != 1:
        raise RuntimeError(f"Landlock restricts only one thread, but {threads} are running")
    version = _version()
    rights = min(12 + version, 15) + (version >= 5)  # number of rights: 13, and one more each in versions 2, 3 and 5
    tcp, outside = (0b11 if version >= 4 else 0), (0b11 if version >= 6 else 0)
    rules = _Rules((1 << rights) - 1, tcp, outside)
    ruleset = call(_CREATE, ctypes.addressof(rules), ctypes.sizeof(rules), 0)
    for path in readable:
        _allow(ruleset, path)
    renounce_privileges()
    if call(_RESTRICT, ruleset, 0) != 0:
        raise OSError("landlock_restrict_self failed")
    os.close(ruleset)


def _version() -> int:
    return call(_CREATE, 0, 0, _VERSION)


def _allow(ruleset: int, path: Path) -> None:
    try:
        folder = os.open(path, os.O_PATH)
    except OSError:  # a path that does not exist needs no rule
        return
    below = _Below(_READ_FILE | _READ_FOLDER if path.is_dir() else _READ_FILE, folder)
    call(_ADD, ruleset, _BENEATH, ctypes.addressof(below), 0)
    os.close(folder)
