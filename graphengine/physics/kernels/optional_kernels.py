"""Loads kernels for modules that also work without numba."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from graphengine.format.process_limits import has_address_space

F = TypeVar("F")

ADDRESS_SPACE = 400_000_000
"""Size of the address space that must be available before numba is used, bytes; 310 MB were measured."""
_log = logging.getLogger(__name__)


def record(integers: str, floats: str) -> np.dtype[Any]:
    """Return the type of the records of a table that kernels read, given the names of its fields, separated by blanks."""
    fields = [(name, kind) for names, kind in ((integers, "i8"), (floats, "f8")) for name in names.split()]
    return np.dtype(fields, align=True)


def load_kernel(load: Callable[[], F | None], work: str) -> F | None:
    """Return the kernel that `load` returns; None if it returns none, or if numba does not work.

    Args:
        load: function that imports numba, and calls the kernel once to compile it.
        work: the work of the kernel in one or two words, for the log.
    """
    try:
        if has_address_space(ADDRESS_SPACE):  # LLVM aborts the process where it finds no memory
            return load()
    except Exception as error:  # numba is not there, or one of its libraries or what it kept is damaged
        _log.debug("without numba: %s: %s", work, error)
    return None
