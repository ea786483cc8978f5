"""`--filter`: an expression of Python about `m`, the message, which the user alone can give."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Filter = Callable[[Any], bool]


def make_filter(text: str | None) -> Filter:
    """What tells whether a message is wanted; without an expression, each is.

    Raises:
        UsageError: it is no expression. The filter itself raises it when the expression fails.
    """
    from graphengine.format.errors import UsageError

    if text is None:
        return lambda message: True
    try:
        code = compile(text, "--filter", "eval")
    except (SyntaxError, ValueError) as error:
        raise UsageError(f"--filter {text!r} is no expression: {error}") from None

    def wanted(message: Any) -> bool:
        try:
            return bool(eval(code, {"m": message}))
        except Exception as error:
            raise UsageError(f"--filter {text!r}: {type(error).__name__}: {error}") from None

    return wanted
