"""Maps errors to the result codes that `simulation_interfaces/msg/Result` and single service types define."""

from __future__ import annotations

from graphengine.format.errors import GraphError, StateError, UnknownEntityError, UsageError

MAX_TEXT = 10_000
"""Maximum length of the text of a result, characters."""
UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)


class RefusedError(UsageError):
    """A request was rejected; the response gets the result code `code`."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


def code_of(error: BaseException) -> int:
    """Return the result code for an exception of the session."""
    if isinstance(error, RefusedError):
        return error.code
    if isinstance(error, UnknownEntityError):
        return NOT_FOUND
    return INCORRECT_STATE if isinstance(error, StateError) else FAILED


def text_of(error: BaseException) -> str:
    """Return the text of an exception for the client; for internal errors, the text begins with the exception's class."""
    text = str(error) if isinstance(error, GraphError) else f"{type(error).__name__}: {error}"
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}…"
