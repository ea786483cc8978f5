"""Decorators for methods of the public API: only one thread at a time may use a session, and a failed session is read-only."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Concatenate, ParamSpec, Protocol, TypeVar

from graphengine.format.errors import StateError

if TYPE_CHECKING:
    from graphengine.api.runner import Runner

P = ParamSpec("P")
T = TypeVar("T")


class HasRunner(Protocol):
    """An object of the public API that belongs to one session, such as a Robot."""

    @property
    def _runner(self) -> Runner: ...


S = TypeVar("S", bound=HasRunner)


def reading(method: Callable[Concatenate[S, P], T]) -> Callable[Concatenate[S, P], T]:
    """Wrap a method so that it raises StateError if another thread uses the session or if the session is closed."""
    return _guarded(method, acts=False)


def acting(method: Callable[Concatenate[S, P], T]) -> Callable[Concatenate[S, P], T]:
    """Wrap a method as `reading` does; in addition, the method raises StateError if the session has failed."""
    return _guarded(method, acts=True)


def _guarded(method: Callable[Concatenate[S, P], T], acts: bool) -> Callable[Concatenate[S, P], T]:
    @functools.wraps(method)
    def guarded(self: S, /, *args: P.args, **kwargs: P.kwargs) -> T:
        runner = self._runner
        runner.enter()
        try:
            if runner.closed:
                raise StateError("the session is closed")
            if acts:
                runner.session.admit()
            return method(self, *args, **kwargs)
        finally:
            runner.lock.release()

    return guarded
