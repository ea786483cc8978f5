"""How an answer says that it is none: the codes of `simulation_interfaces/msg/Result` and of single services."""

from __future__ import annotations

from graphengine.format.errors import GraphError, StateError, UnknownEntityError, UsageError

MAX_TEXT = 10_000
UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)


class RefusedError(UsageError):
    """A request that is not fulfilled, with the code that says why."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


def code_of(error: BaseException) -> int:
    """The code of what a session raised."""
    if isinstance(error, RefusedError):
        return error.code
    if isinstance(error, UnknownEntityError):
        return NOT_FOUND
    return INCORRECT_STATE if isinstance(error, StateError) else FAILED


def text_of(error: BaseException) -> str:
    """What to tell the caller: what this package raises is meant for people, and nothing else is."""
    text = str(error) if isinstance(error, GraphError) else f"{type(error).__name__}: {error}"
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}…"
