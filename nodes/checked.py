"""Functions that check input values, for nodes that cannot use every value of a port's type."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from graphengine.node import BadValueError, Node, PortType


def check_finite(node: Node, *fields: str) -> None:
    """Check that numeric inputs of a node are finite.

    Args:
        node: node with the inputs.
        fields: Python names of the inputs to check. Their values are numbers, tuples of numbers or arrays.

    Raises:
        BadValueError: a number is infinite or NaN.
    """
    for field in fields:
        value = getattr(node, field)
        if isinstance(value, np.ndarray):
            is_finite = bool(np.isfinite(value).all())
        else:
            is_finite = all(map(math.isfinite, value if isinstance(value, tuple) else (value,)))
        if not is_finite:
            raise BadValueError(type(node).fields[field].name, value, "finite")


def one_of(port: str, value: str, legal: Collection[str]) -> str:
    """Return `value` if it is one of the legal values of an input.

    Args:
        port: OmniGraph name of the input, for the error message.
        value: value of the input.
        legal: all legal values of the input.

    Raises:
        BadValueError: `value` is not one of the legal values.
    """
    if value not in legal:
        raise BadValueError(port, value, f"one of {', '.join(legal)}")
    return value


def same_length(**arrays: Any) -> None:
    """Check that all given arrays have the same length.

    Pass each array by keyword. The keyword is the OmniGraph name of the array's port, for the error message.

    Raises:
        BadValueError: two arrays differ in length.
    """
    lengths = list(map(len, arrays.values()))
    if len(set(lengths)) > 1:
        raise BadValueError(", ".join(arrays), lengths, "of the same length")


def check_outcome(node: Node, *outcome: float) -> None:
    """Check that the computed numbers in `outcome` are finite and that no scalar input of the node is NaN.

    Raises:
        BadValueError: a computed number is infinite or NaN, or a scalar input is NaN. The error names all inputs that are not
            finite. If all inputs are finite, the error names all floating-point inputs of the node.
    """
    inputs, numbers = _numbers(type(node))
    given_numbers = numbers(node)
    if math.isfinite(sum(outcome)) and not math.isnan(sum(given_numbers)):
        return  # a sum shows at once what is not finite; one that is too large for a double needs the look at each
    if all(map(math.isfinite, outcome)) and not any(map(math.isnan, given_numbers)):
        return
    given = [(name, getattr(node, field)) for name, field in inputs]
    wrong = [(name, value) for name, value in given if not all(map(math.isfinite, np.ravel(value)))] or given
    raise BadValueError(", ".join(name for name, _ in wrong), [value for _, value in wrong], "finite and not too large")


@functools.cache
def _numbers(cls: type[Node]) -> tuple[list[tuple[str, str]], Callable[[Node], tuple[float, ...]]]:
    """Return (port name, Python name) of each floating-point input, and a function that returns the scalar ones as a tuple.

    The node class needs two or more scalar floating-point inputs; for a single input, the function would not return a tuple.
    """
    inputs = [port for port in cls.fields.values() if port.side == "inputs"]
    real = [port for port in inputs if isinstance(port.type, PortType) and port.type.base in ("double", "float")]
    single = [port.field for port in real if isinstance(port.default, float)]
    return [(port.name, port.field) for port in real], operator.attrgetter(*single)
