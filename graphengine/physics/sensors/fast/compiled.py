"""Compiles the kernels of this package with numba.

A kernel is compiled at its first call, and cached for later processes. It runs without Python's global interpreter lock.
Division by zero gives infinity, as the box test needs. Operations are not reordered or fused, so that results are the same on
every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

_njit = partial(numba.njit, nogil=True, error_model="numpy")


def kernel(function: F) -> F:
    """Return a function compiled to machine code, which Python can call.

    numba caches the machine code beside the source file. If that folder cannot be written, it uses the user's cache folder; if
    neither can be written, the code is not cached.
    """
    try:
        return cast(F, _njit(cache=True)(function))
    except RuntimeError:  # no folder to keep it in
        return part(function)


def kept_in(function: F) -> str:
    """Return the path of the folder in which numba caches a kernel."""
    return str(cast(Any, function).stats.cache_path)


def part(function: F) -> F:
    """Return a function compiled to machine code, which only kernels of the same file may call.

    numba's cache of a kernel does not notice changes in other files.
    """
    return cast(F, _njit()(function))
