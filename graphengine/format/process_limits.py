"""Checks of process resources without which C libraries abort the process instead of reporting an error."""

from __future__ import annotations

import mmap
import os

SMALLEST = 320_000_000
"""Address space that a command needs before Python can report a lack of memory, bytes; mostly for OpenBLAS and MuJoCo."""


def has_address_space(size: int) -> bool:
    """Return whether `ulimit -v` and the machine allow this many more bytes; the bytes are released again."""
    try:
        mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ).close()
    except (OSError, MemoryError):
        return False
    return True


def has_descriptors(number: int) -> bool:
    """Return whether `ulimit -n` and the machine allow this many more open files."""
    opened: list[int] = []
    try:
        while len(opened) < number:
            opened.append(os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC))
    except OSError:
        return False
    finally:
        for descriptor in opened:
            os.close(descriptor)
    return True
