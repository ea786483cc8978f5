"""`--filter`: a Python expression of `m`, the message."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from graphengine.format.errors import UsageError
from graphengine.sandbox.expressions import FUNCTIONS, ForbiddenError, Guard, compiled

Filter = Callable[[Any], bool]

_ARRAY = frozenset(
    ("all", "any", "argmax", "argmin", "max", "mean", "min", "ndim", "shape", "size", "std", "sum", "tolist")
)


class _MessageGuard(Guard):
    """Reads the fields of messages, and of arrays what has bounds."""

    def attributes(self, value: Any) -> Collection[str]:
        if hasattr(value, "__msgtype__"):
            return frozenset(value.__dataclass_fields__) - {"__msgtype__"}
        return _ARRAY if hasattr(value, "__array_interface__") else super().attributes(value)


def make_filter(text: str | None) -> Filter:
    """A function that returns whether a message is wanted; without an expression, each is.

    Raises:
        UsageError: it is no expression, or one that is not allowed. The filter itself raises it when the expression fails.
    """
    if text is None:
        return lambda message: True
    try:
        code = compiled(text, known=("m", *FUNCTIONS))
    except (SyntaxError, ValueError, ForbiddenError) as error:
        raise UsageError(f"--filter {text!r} is no expression: {error}") from None

    def wanted(message: Any) -> bool:
        try:
            return bool(_MessageGuard().evaluate(code, {**FUNCTIONS, "m": message}))
        except ForbiddenError as error:
            raise UsageError(f"--filter {text!r}: {error}") from None
        except Exception as error:
            raise UsageError(f"--filter {text!r}: {type(error).__name__}: {error}") from None

    return wanted
