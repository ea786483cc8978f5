"""Compiles kernels with numba.

A kernel is compiled at its first call, and cached for later processes. It runs without Python's global interpreter lock. Division
by zero gives infinity, as the box test needs. Operations are not reordered or fused. So results are the same on every machine.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from types import ModuleType
from typing import Any, TypeVar, cast

import numba
from numba.core.event import Event, Listener, install_listener

F = TypeVar("F", bound=Callable[..., Any])

_log = logging.getLogger(__name__)
_njit = partial(numba.njit, nogil=True, error_model="numpy")


def kernel(function: F) -> F:
    """Return a function compiled to machine code. Python can call it.

    numba caches the machine code beside the source file. If that folder cannot be written, it uses the user's cache folder; if
    neither can be written, the code is not cached.
    """
    try:
        return cast(F, _njit(cache=True)(function))
    except RuntimeError:  # no folder to keep it in
        return part(function)


def kernel_of(*modules: ModuleType) -> Callable[[F], F]:
    """Return `kernel` for a kernel that calls parts of other modules, or contains their constants.

    numba's cache of a kernel does not notice changes in these modules. So the names of the cached files contain a digest of them.
    """
    digest = hashlib.sha256("".join(map(inspect.getsource, modules)).encode()).hexdigest()

    def decorate(function: F) -> F:
        function.__qualname__ = f"{function.__name__}_{digest[:12]}"
        return kernel(function)

    return decorate


def kept_in(function: F) -> str:
    """Return the path of the folder in which numba caches a kernel."""
    return str(cast(Any, function).stats.cache_path)


def part(function: F) -> F:
    """Return a function compiled to machine code. Only kernels may call it.

    A kernel in another file must name the module of the function in `kernel_of`.
    """
    return cast(F, _njit()(function))


def announced(work: str) -> AbstractContextManager[Any]:
    """Return a context that logs when numba compiles a kernel in it for the first time; loading it from the cache does not count.

    Args:
        work: the work of the kernels in a few words, for the message.
    """
    return cast(AbstractContextManager[Any], install_listener("numba:compile", _Notice(work)))


class _Notice(Listener):  # type: ignore[misc]  # numba has no types
    def __init__(self, work: str) -> None:
        self._work, self._logged = work, False

    def on_start(self, event: Event) -> None:
        """Log a message for the first event."""
        if not self._logged:
            self._logged = True
            _log.warning("compiling %s, which takes some seconds", self._work)

    def on_end(self, event: Event) -> None:
        """Do nothing."""
