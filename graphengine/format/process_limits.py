"""Checks for free address space and file descriptors; without these, C libraries abort the process without a message."""

from __future__ import annotations

import mmap
import os

SMALLEST = 320_000_000
"""Smallest address space with which a command can run, bytes; with less, OpenBLAS and MuJoCo abort the process."""


def has_address_space(size: int) -> bool:
    """Return whether `size` more bytes can be mapped under `ulimit -v` and the machine's limits; nothing stays mapped."""
    try:
        mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ).close()
    except (OSError, MemoryError):
        return False
    return True


def has_descriptors(number: int) -> bool:
    """Return whether `number` more files can be opened under `ulimit -n` and the machine's limits; no file stays open."""
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
