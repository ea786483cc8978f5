"""Evaluates the expressions `${…}` of xacro files in a restricted way that replaces Python's `eval`.

Expressions may contain lambdas, read namespaces of xacro and YAML mappings as attributes, and change lists and mappings. The
process in which this module runs also limits time and memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from graphengine.sandbox.expressions import METHODS, SYNTAX, Guard, compiled, syntax

_SYNTAX = (*SYNTAX, *syntax("Lambda arguments arg"))
_MORE: Mapping[type, str] = {
    str: "join replace zfill ljust rjust",
    list: "append extend insert remove pop reverse sort copy clear",
    dict: "copy update pop setdefault",
    set: "add discard",
}


class _Guard(Guard):
    methods = MappingProxyType({kind: names | {*_MORE.get(kind, "").split()} for kind, names in METHODS.items()})

    def attribute(self, value: Any, name: str) -> Any:
        if isinstance(value, dict) and name not in self.methods[dict]:
            try:
                return value[name]  # xacro's namespaces and YAML mappings
            except (KeyError, AttributeError):
                raise NameError(f"the namespace or mapping has no entry {name!r}") from None
        return super().attribute(value, name)

    def call(self, place: tuple[int, int, int], function: Any, /, *arguments: Any, **named: Any) -> Any:
        return function(*arguments, **named)

    def weigh(self, *values: Any) -> None:
        """Do nothing: values may have any size, because YAML files may be large; the process has a memory limit instead."""


def evaluate(expression: str, names: dict[str, Any]) -> Any:
    """Return the value of an expression; `names` maps names to values, and may compute them on access.

    Raises:
        ForbiddenError: the expression uses forbidden syntax, names or attributes, or exceeds the limits.
        Exception: any exception that the evaluation raises.
    """
    return _Guard().evaluate(compiled(expression, _SYNTAX), names)
