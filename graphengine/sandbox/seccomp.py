"""seccomp: makes the kernel permanently deny this process all system calls that are not in a list.

Linux has this feature since 3.17, unless it is disabled at build time. A filter is a classic BPF program that reads the
`seccomp_data` of linux/seccomp.h; call numbers are those of asm/unistd.h. A denied call fails with EPERM; libraries can then
continue.
"""

from __future__ import annotations

import ctypes
import errno
import os
import struct
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from graphengine.sandbox.system_calls import call, renounce_privileges

ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
"""Supported machines, in the order of the columns of `_TABLE`, with their AUDIT_ARCH numbers of linux/audit.h."""

_TABLE = Path(__file__).with_suffix(".txt").read_text("utf-8")
"""Allowed system calls: name, number on x86_64, number on aarch64 (`-` if the machine lacks the call).

The three groups are for every process, for reading files, and for starting threads.
"""

_ALLOWED, _ERROR, _KILLED = 0x7FFF0000, 0x00050000, 0x80000000
"""Return values of a filter: allow the call, fail with the error number in the lower 16 bits, kill the process."""
_LOAD, _AND, _RETURN, _EQUAL, _AT_LEAST = 0x20, 0x54, 0x06, 0x15, 0x35
"""Operation codes of classic BPF: ld [k], and #k, ret #k, jeq #k, jge #k."""
_NUMBER, _ARCHITECTURE = 0, 4
"""Offsets of the call number and the architecture in `seccomp_data`, bytes."""
_ALL = 0xFFFFFFFF
_FOREIGN = 0x40000000
"""Smallest call number of x32, a second system call interface of x86_64, which is denied."""

_READ_FLAGS = os.O_CLOEXEC | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_NOCTTY | 0o100000 | 0o400000
"""Flags of open(2) that are allowed for reading; the numbers cover O_LARGEFILE and O_NOFOLLOW of both machines."""
_THREAD = 0x3D0F00
"""Flags of clone(2) with which pthread_create starts a thread; no other use of clone(2) is allowed."""
_TERMINAL, _CLOSE_ON_EXEC, _STAY_ON_EXEC = 0x5401, 0x5451, 0x5450
"""Allowed requests of ioctl(2): TCGETS (query a terminal), FIOCLEX and FIONCLEX (set or clear close-on-exec)."""
_ADVICE = (*range(5), 8, 14, 15, 102, 103)
"""Allowed advice values of madvise(2): expected use, MADV_FREE, huge pages and guard pages.

Other values can take pages from the whole machine, or share pages.
"""
_DUPLICATE = (0, 1, 2, 3, 1030)
"""Allowed commands of fcntl(2): F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_DUPFD_CLOEXEC."""

_SET_FILTER, _ACTION_AVAILABLE, _ALL_THREADS = 1, 2, 1
"""SECCOMP_SET_MODE_FILTER, SECCOMP_GET_ACTION_AVAIL and SECCOMP_FILTER_FLAG_TSYNC of seccomp(2)."""
_SECCOMP = {"x86_64": 317, "aarch64": 277}


class Test(NamedTuple):
    """A condition on an argument of a system call: 32 bits of it, after masking, must be one of `values`.

    Attributes:
        argument: index of the argument, 0 to 5.
        values: allowed values.
        mask: bits to test.
        high: whether to test the upper instead of the lower 32 bits.
    """

    argument: int
    values: tuple[int, ...]
    mask: int = _ALL
    high: bool = False


class Tier(NamedTuple):
    """Permissions of a process in addition to computing and using files that are already open."""

    files: bool
    """Whether the process may open files for reading and list folders."""
    threads: bool


TIERS = {
    "script": Tier(files=True, threads=True),
    "stage": Tier(files=True, threads=False),
    "xacro": Tier(files=True, threads=False),
    "mesh": Tier(files=False, threads=False),
}
"""Permissions of a process for each kind of file that it reads."""


def numbers(machine: str) -> list[dict[str, int]]:
    """Return the three groups of `_TABLE` for a machine, as dicts from names of system calls to their numbers."""
    column = 1 + list(ARCHITECTURES).index(machine)
    tables = []
    for part in _TABLE.split("\n\n"):
        words = part.split()
        rows = [words[start : start + 3] for start in range(0, len(words), 3)]
        tables.append({row[0]: int(row[column]) for row in rows if row[column] != "-"})
    return tables


def available() -> bool:
    """Return whether this kernel has seccomp with the required action, and `_TABLE` covers this machine."""
    action = ctypes.c_uint32(_KILLED)
    machine = os.uname().machine
    return machine in ARCHITECTURES and call(_SECCOMP[machine], _ACTION_AVAILABLE, 0, ctypes.addressof(action)) == 0


def restrict(tier: Tier) -> None:
    """Deny all threads of this process the system calls that the tier does not allow.

    Raises:
        OSError: the kernel does not accept the filter.
    """
    program = compose(os.uname().machine, tier, os.getpid())
    text = ctypes.create_string_buffer(program, len(program))

    class Program(ctypes.Structure):
        _fields_ = (("length", ctypes.c_ushort), ("text", ctypes.c_void_p))

    described = Program(len(program) // 8, ctypes.addressof(text))
    renounce_privileges()
    if call(_SECCOMP[os.uname().machine], _SET_FILTER, _ALL_THREADS, ctypes.addressof(described)) != 0:
        raise OSError("the seccomp filter cannot be installed")


def compose(machine: str, tier: Tier, process: int) -> bytes:
    """Return the BPF program for a tier in the kernel's format, 8 bytes per instruction; `process` is the process ID."""
    every, files, threads = numbers(machine)
    listed = {**every, **(files if tier.files else {}), **(threads if tier.threads else {})}
    tests = _tests(process)
    code = [(_LOAD, 0, 0, _ARCHITECTURE), (_EQUAL, 1, 0, ARCHITECTURES[machine]), (_RETURN, 0, 0, _KILLED)]
    code += [(_LOAD, 0, 0, _NUMBER), (_AT_LEAST, 0, 1, _FOREIGN), (_RETURN, 0, 0, _ERROR | errno.EPERM)]
    for name, number in listed.items():
        body = list(_body(name, tests.get(name, ())))
        code += [(_EQUAL, 0, len(body), number), *body]
    code.append((_RETURN, 0, 0, _ERROR | errno.EPERM))
    return b"".join(struct.pack("<HBBI", *instruction) for instruction in code)


def _body(name: str, tests: Collection[Test]) -> Iterator[tuple[int, int, int, int]]:
    """Yield the instructions that allow or deny a listed system call, depending on `tests` of its arguments."""
    if name in ("clone3", "openat2"):  # their arguments lie in memory; libraries fall back to clone and openat
        yield _RETURN, 0, 0, _ERROR | errno.ENOSYS
        return
    for test in tests:
        yield _LOAD, 0, 0, 16 + 8 * test.argument + 4 * test.high
        yield _AND, 0, 0, test.mask
        for left, value in zip(range(len(test.values), 0, -1), test.values, strict=True):
            yield _EQUAL, left, 0, value
        yield _RETURN, 0, 0, _ERROR | errno.EPERM
    yield _RETURN, 0, 0, _ALLOWED


def _tests(process: int) -> dict[str, tuple[Test, ...]]:
    """Return a dict from names of system calls that are allowed only with certain arguments to the tests of the arguments.

    The kernel ignores the upper 32 bits of an int argument; therefore most tests need only the lower 32 bits.
    """
    return {
        "open": (Test(1, (0,), _ALL & ~_READ_FLAGS),),
        "openat": (Test(2, (0,), _ALL & ~_READ_FLAGS),),
        "clone": (Test(0, (_THREAD,)),),
        "fcntl": (Test(1, _DUPLICATE),),
        "ioctl": (Test(1, (_TERMINAL, _CLOSE_ON_EXEC, _STAY_ON_EXEC)),),
        "madvise": (Test(2, _ADVICE),),
        "tgkill": (Test(0, (process,)),),
        "prlimit64": (Test(0, (0,)), Test(2, (0,)), Test(2, (0,), high=True)),  # query the own limits only
    }
