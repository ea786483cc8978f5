"""Functions that compute element-wise operations on port values with numpy, and determine the types of the results.

Shapes: a scalar combines with any value, and a tuple combines with a tuple of the same length. An array combines with an array
of the same length or of one element. A scalar or a tuple combines with each element of an array.

Types: the base type of the result is the widest base type of the operands, in the order uchar, int, uint, int64, uint64, half,
float, double: an int and a float give a float. The result is a timecode only if all operands are timecodes. Tuples of integers
always have the base type int.

Precision: real numbers are computed as doubles. A result array is rounded to its base type, but a scalar float stays a Python
float with the precision of a double. Integers that exceed the range of their base type wrap around.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from graphengine.node import BadValueError, PortType, types
from graphengine.node.types import INTEGERS

Operation = Callable[..., Any]

_WIDENING = ("bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double")
_REALS = ("half", "float", "double", "timecode")


@dataclass(frozen=True, slots=True)
class Operand(PortType):
    """The type of an operand, and the name of its input for error messages."""

    port: str = ""
    """OmniGraph name of the input."""

    @staticmethod
    def of(port_type: PortType, port: str) -> Operand:
        """Return an operand from its type and the OmniGraph name of its input."""
        return Operand(port_type.base, port_type.count, port_type.array, port_type.role, port)


def is_real(port_type: PortType) -> bool:
    """Return whether a type consists of real numbers: half, float, double or timecode."""
    return port_type.base in _REALS


def common(operands: Mapping[str, PortType]) -> PortType:
    """Return the common type of the operands: the result type of an element-wise operation.

    Args:
        operands: a dict from port names to the types of the operands.

    Raises:
        ValueError: two operands are tuples of different lengths.
    """
    tuples = {name: operand for name, operand in operands.items() if operand.count > 1}
    first = next(iter(tuples), "")
    for name, operand in tuples.items():
        if operand.count != tuples[first].count:
            raise ValueError(f"{first} is {tuples[first]} and {name} is {operand}; tuples must have the same length")
    count = tuples[first].count if tuples else 1
    base = _widest((operand.base for operand in operands.values()), count)
    role = tuples[first].role if tuples and base in _REALS else ""
    return PortType(base, count, any(operand.array for operand in operands.values()), role)


def _widest(bases: Iterable[str], count: int) -> str:
    found = set(bases)
    if found == {"timecode"} and count == 1:
        return "timecode"
    base = max(("double" if base == "timecode" else base for base in found), key=_WIDENING.index)
    return "int" if count > 1 and base not in (*_REALS, "bool") else base


def type_of(value: Any) -> PortType:
    """Return the port type that matches a Python value. Nodes outside a graph use it, because their types are not resolved."""
    if isinstance(value, np.ndarray):
        base = next(base for base in _WIDENING if PortType(base).dtype == value.dtype)
        return PortType(base, value.shape[1] if value.ndim == 2 else 1, True)
    if isinstance(value, tuple):
        texts = not value or isinstance(value[0], str)
        return PortType("token", 1, True) if texts else PortType(type_of(sum(value)).base, len(value))
    names = {bool: "bool", int: "int", float: "double", str: "token"}
    return PortType(names[type(value)])


def lift(
    function: Operation, inputs: Sequence[PortType], output: PortType, on_numbers: Operation | None = None
) -> Operation:
    """Wrap a function of numpy arrays, and return a function that takes and returns port values.

    The returned function raises BadValueError if two arrays differ in length.

    Args:
        function: function of arrays that broadcast against each other. If an argument is a tuple or an array of tuples, the
            last axis holds the components.
        inputs: types of the arguments. An `Operand` also gives the port name for the error message.
        output: type of the result.
        on_numbers: the same function for Python numbers. It computes scalars and tuples, for which numpy takes ten times as long.
    """
    has_arrays = any(one.array for one in (*inputs, output))
    if on_numbers is not None and not has_arrays and output.count == max(given.count for given in inputs):
        return _of_tuples(on_numbers, inputs, output)
    real = any(map(is_real, (*inputs, output)))
    dtype = np.dtype(np.float64) if real else common({str(i): one for i, one in enumerate(inputs)}).dtype
    kinds = [np.float64 if is_real(one) else one.dtype for one in inputs]
    arrays_in = [i for i, one in enumerate(inputs) if one.array]
    tuples = any(one.count > 1 for one in inputs)
    names = ", ".join(one.port for one in inputs if one.array and isinstance(one, Operand)) or "arrays"
    columns = [i for i in arrays_in if tuples and inputs[i].count == 1]  # one number for each tuple of another array

    def lifted(*values: Any) -> Any:
        arrays = [np.asarray(value, kind).astype(dtype, copy=False) for value, kind in zip(values, kinds, strict=True)]
        if len(arrays_in) > 1:
            _check_lengths(names, [len(arrays[i]) for i in arrays_in])
        for i in columns:
            arrays[i] = arrays[i][:, None]
        with np.errstate(all="ignore"):
            return represented(function(*arrays), output)

    return lifted


def _check_lengths(names: str, lengths: Sequence[int]) -> None:
    """Check that all arrays have the same length, except for arrays of one element."""
    if len(set(lengths) - {1}) > 1:
        raise BadValueError(names, list(lengths), "of the same length, or of one element")


def _of_tuples(on_numbers: Operation, inputs: Sequence[PortType], output: PortType) -> Operation:
    """Return a function of scalars and tuples that applies a function of numbers to each component."""
    one = _of_numbers(on_numbers, [replace(given, count=1) for given in inputs], replace(output, count=1))
    if output.count == 1:
        return one
    if all(given.count > 1 for given in inputs):
        return lambda *tuples: tuple(map(one, *tuples))
    single = [given.count == 1 for given in inputs]

    def spread(*values: Any) -> Any:
        columns = [itertools.repeat(value) if alone else value for value, alone in zip(values, single, strict=True)]
        return tuple(map(one, *columns))

    return spread


def _of_numbers(function: Operation, inputs: Sequence[PortType], output: PortType) -> Operation:
    if is_real(output):
        return function if all(map(is_real, inputs)) else lambda *values: function(*map(float, values))
    if output.base == "bool":
        return function
    if any(map(is_real, inputs)):
        return lambda *values: _whole(function(*values), output)
    low, high = INTEGERS[output.base]
    return lambda *values: (function(*values) - low) % (high - low + 1) + low


def _whole(number: float, output: PortType) -> int:
    """Return a real number truncated toward 0, as an integer of the output type."""
    low, high = INTEGERS[output.base]
    if not low - 1 < number < high + 1:
        raise BadValueError("result", number, f"in the range of {output.base}, {low} to {high}")
    return int(number)


def represented(result: Any, output: PortType) -> Any:
    """Return a numpy result in the Python representation of a port type.

    Raises:
        BadValueError: the port type consists of integers, and a real number in the result is NaN or out of range.
    """
    array = np.asarray(result)
    if array.dtype.kind == "f" and not is_real(output) and output.base != "bool":
        low, high = INTEGERS[output.base]
        array = np.trunc(array)
        for wrong in array[~((array >= low) & (array < high + 1))].tolist():
            _whole(wrong, output)
    if output.array:
        return np.ascontiguousarray(array, output.dtype)
    return types.plain(array if is_real(output) else array.astype(output.dtype))
