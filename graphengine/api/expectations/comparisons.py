"""Samples of comparisons: whether a comparison holds, and its margin."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

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


def certain(holds: bool) -> float:
    """Return the margin of a value without a limit."""
    return math.inf if holds else -math.inf


def unordered(a: Any, b: Any, holds: bool) -> float:
    """Return the margin of a comparison of two equal infinities.

    Raises:
        ValueError: a side is NaN.
    """
    if any(isinstance(side, float) and side != side for side in (a, b)):
        raise ValueError("a side of a comparison is not a number (NaN)")
    return certain(holds)


def compared(operators: Sequence[_Comparison], *sides: Any) -> tuple[bool, float]:
    """Return whether a chain of comparisons holds, and the smallest of their margins."""
    samples = [_pair(*each) for each in zip(operators, sides, sides[1:], strict=False)]
    return min(samples) if len(samples) > 1 else samples[0]


def _pair(operators: _Comparison, first: Any, second: Any) -> tuple[bool, float]:
    holds, margin = operators
    unordered(first, second, False)
    held = bool(holds(first, second))
    try:
        difference = float(margin(first, second))
    except TypeError:
        return held, certain(held)
    return held, difference if difference == difference else certain(held)
