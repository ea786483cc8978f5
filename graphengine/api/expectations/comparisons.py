"""Samples of comparisons, and of several conditions joined by `and` or `or`."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from graphengine.api.expectations.operators import Sample

_Comparison = tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]
COMPARISONS: Mapping[type[ast.cmpop], _Comparison] = {
    ast.Lt: (operator.lt, lambda a, b: b - a),
    ast.LtE: (operator.le, lambda a, b: b - a),
    ast.Gt: (operator.gt, lambda a, b: a - b),
    ast.GtE: (operator.ge, lambda a, b: a - b),
    ast.Eq: (operator.eq, lambda a, b: -abs(a - b)),
    ast.NotEq: (operator.ne, lambda a, b: abs(a - b)),
    ast.In: (lambda a, b: a in b, lambda a, b: math.nan),
    ast.NotIn: (lambda a, b: a not in b, lambda a, b: math.nan),
}
"""The operator and the margin of each comparison; NaN stands for an infinite margin."""


def below(a: Any, b: Any) -> Sample:
    """Return the sample of `a < b` for two numbers."""
    return _ordered(bool(a < b), b - a, a, b)


def at_most(a: Any, b: Any) -> Sample:
    """Return the sample of `a <= b` for two numbers."""
    return _ordered(bool(a <= b), b - a, a, b)


def _ordered(held: bool, margin: Any, a: Any, b: Any) -> Sample:
    if margin == margin:
        return Sample(held, float(margin))
    _refuse_nan(a, b)
    return certain(held)  # both sides are infinite


def _refuse_nan(*sides: Any) -> None:
    if any(isinstance(side, float) and side != side for side in sides):
        raise ValueError("a side of a comparison is not a number (NaN)")


ORDERS: Mapping[type[ast.cmpop], tuple[str, int]] = {
    ast.Lt: ("_below", 1),
    ast.LtE: ("_at_most", 1),
    ast.Gt: ("_below", -1),
    ast.GtE: ("_at_most", -1),
}
"""For each operator, a function that compares two numbers (the most frequent condition) in one call, and its argument order."""


def certain(holds: bool) -> Sample:
    """Return the sample of a value without a margin."""
    return Sample(holds, math.inf if holds else -math.inf)


def joined(
    parts: Sequence[Callable[[], Sample]],
    holds: Callable[[Iterable[bool]], bool],
    margin: Callable[[Iterable[float]], float],
) -> Callable[[], Sample]:
    """Return a function that evaluates all parts, without short-circuiting, and joins their samples."""

    def evaluate() -> Sample:
        samples = [part() for part in parts]
        return Sample(holds(sample.holds for sample in samples), margin(sample.margin for sample in samples))

    return evaluate


def compared(operators: Sequence[_Comparison], sides: Sequence[Callable[[], Any]]) -> Callable[[], Sample]:
    """Return a function that evaluates a chain of comparisons and each of its sides exactly once."""

    def evaluate() -> Sample:
        values = [side() for side in sides]
        samples = [_pair(*each) for each in zip(operators, values, values[1:], strict=False)]
        return min(samples) if len(samples) > 1 else samples[0]

    return evaluate


def _pair(operators: _Comparison, first: Any, second: Any) -> Sample:
    holds, margin = operators
    _refuse_nan(first, second)
    held = bool(holds(first, second))
    try:
        difference = float(margin(first, second))
    except TypeError:
        return certain(held)
    return Sample(held, difference) if difference == difference else certain(held)
