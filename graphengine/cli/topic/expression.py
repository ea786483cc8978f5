"""The option `--filter` of `graphrun topic`: a Python expression that can use only the message `m` and safe functions."""

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
    """Lets expressions read the fields of messages, and the attributes and methods of arrays that `_ARRAY` lists."""

    def attributes(self, value: Any) -> Collection[str]:
        if hasattr(value, "__msgtype__"):
            return frozenset(value.__dataclass_fields__) - {"__msgtype__"}
        return _ARRAY if hasattr(value, "__array_interface__") else super().attributes(value)


def make_filter(text: str | None) -> Filter:
    """Return the function that applies the filter `text` to a message; without a text, every message passes.

    The returned function raises UsageError if the expression fails for a message.

    Raises:
        UsageError: the text is not a legal expression.
    """
    if text is None:
        return lambda message: True
    try:
        code = compiled(text, known=("m", *FUNCTIONS))
    except (SyntaxError, ValueError, ForbiddenError) as error:
        raise UsageError(f"--filter {text!r} is not an expression: {error}") from None

    def wanted(message: Any) -> bool:
        try:
            return bool(_MessageGuard().evaluate(code, {**FUNCTIONS, "m": message}))
        except ForbiddenError as error:
            raise UsageError(f"--filter {text!r}: {error}") from None
        except Exception as error:
            raise UsageError(f"--filter {text!r}: {type(error).__name__}: {error}") from None

    return wanted
