"""Compiles the kernels of this package: at their first call, to run without the interpreter's lock, cached for later processes.

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
    """Return a function as machine code that Python can call.

    numba caches it beside the source file, else in the user's cache folder, or not at all if neither can be written.
    """
    try:
        return cast(F, _njit(cache=True)(function))
    except RuntimeError:  # no folder to keep it in
        return part(function)


def kept_in(function: F) -> str:
    """Return the folder in which numba caches a kernel."""
    return str(cast(Any, function).stats.cache_path)


def part(function: F) -> F:
    """Return a function as machine code that only kernels of the same file may call: numba's cache ignores other files."""
    return cast(F, _njit()(function))
