"""How the kernels of this package are compiled: on their first call, outside the interpreter's lock, kept for the next process.

Division by zero gives infinity, as a test of slabs wants it. Operations are neither rearranged nor fused, so that the same comes
out on every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

_njit = partial(numba.njit, nogil=True, error_model="numpy")


def kernel(function: F) -> F:
    """The function as machine code, for Python to call.

    numba keeps it beside the source file, else in the user's own cache folder; where neither can be written, nowhere.
    """
    try:
        return cast(F, _njit(cache=True)(function))
    except RuntimeError:  # no folder to keep it in
        return part(function)


def kept_in(function: F) -> str:
    """Folder in which numba keeps a kernel."""
    return str(cast(Any, function).stats.cache_path)


def part(function: F) -> F:
    """The function as machine code, for kernels in its own file to call: numba does not see what changes in another."""
    return cast(F, _njit()(function))
