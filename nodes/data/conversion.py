"""Nodes that convert values to other types (`omni.graph.nodes`). Unlike conversions on wires, they can lose information."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from graphengine.node import BadValueError, In, Node, Out, types
from graphengine.node.types import PortType, String, Target, Token, UnionType, plain
from graphengine.nodes.data.broadcast import type_of
from graphengine.nodes.data.unions import PLAIN_NUMERICS, tuples, with_arrays, with_roles

_SCALARS = with_arrays("bool|int|int64|uint64|uint|uchar|double|float|half")
_NUMBERS = f"{PLAIN_NUMERICS}|bool|bool[]"
_ROLES = {"Color": "color", "Normal": "normal", "Point": "point", "Quaternion": "quat", "TexCoord": "texcoord"}
_ROLES |= {"Vector": "vector", "Frame": "frame", "Timecode": "", "None": ""}
_HALF_ROLES = ("None", "Color", "Frame", "Normal", "Point", "Quaternion", "TexCoord", "Timecode", "Vector")


def _tuples(base: str) -> str:
    return with_arrays(f"{base}|{tuples(base)}")


def _with_roles(base: str) -> str:
    return f"{_tuples(base)}|{with_arrays(with_roles(base[0]))}"


class Conversion(Node):
    """Base class of nodes that convert the numbers of a value to another base type and keep the shape."""

    base: ClassVar[str]

    value: Any
    converted: Any

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the output: the base type of the node in the shape of the input."""
        return {"converted": self.result_type(known["value"])} if "value" in known else {}

    def result_type(self, given: PortType) -> PortType:
        """Return the output type for the given input type."""
        return PortType(self.base, given.count, given.array or given.base == "string")

    def compute(self) -> None:
        """Set the output to the converted value.

        Raises:
            BadValueError: the output consists of integers, and a real number in the input is NaN or too large.
        """
        value = np.frombuffer(self.value.encode(), np.uint8) if isinstance(self.value, str) else self.value
        given = self.settled.get("value") or type_of(self.value)
        result = numbers(np.asarray(value, None if isinstance(value, np.ndarray) else given.dtype), self.base)
        self.converted = result if isinstance(value, np.ndarray) else plain(result)


def numbers(array: np.ndarray[Any, Any], base: str) -> np.ndarray[Any, Any]:
    """Return an array of numbers converted to another base type.

    On conversion to integers, real numbers are truncated toward 0, and numbers out of range wrap around as in C.

    Raises:
        BadValueError: the base type is an integer of n bits, and a real number is NaN or has a magnitude of 2^n or more.
    """
    dtype = PortType(base).dtype
    if array.dtype.kind == "f" and np.dtype(dtype).kind in "iu":
        whole, bits = np.trunc(array.astype(np.float64)), np.iinfo(dtype).bits
        wrong = whole[~(np.abs(whole) < 2.0**bits)]
        if wrong.size:
            raise BadValueError("value", float(wrong.flat[0]), f"a number that the type {base} can hold")
        wrapped = [int(number) % 2**bits for number in whole.ravel().tolist()]
        return np.array(wrapped, np.uint64).reshape(array.shape).astype(dtype)
    with np.errstate(over="ignore"):
        return array.astype(dtype)


_ROLE = "role of the output; ignored if the role has no tuples of the value's length"


class RoledConversion(Conversion):
    """Base class of conversions to real numbers. The input `role` selects the role of the output, such as Color."""

    role: Token

    def result_type(self, given: PortType) -> PortType:
        """Return the output type for an input type, with the chosen role if this role has tuples of the input's length."""
        bare, role = super().result_type(given), _ROLES[self.role]
        wanted, legal = replace(bare, role=role), type(self).fields["converted"].type
        assert isinstance(legal, UnionType)
        return wanted if wanted in legal.alternatives else bare


class ScalarConversion(Conversion):
    """Base class of conversions that accept numbers and arrays of numbers, but no tuples."""

    value: Any = In(type=_SCALARS, required=True, doc="number to convert, or array of numbers")


class ToBool(ScalarConversion, type="omni.graph.nodes.ToBool"):
    """Converts numbers to booleans: 0 becomes false, every other number becomes true."""

    base = "bool"

    converted: Any = Out(type="bool|bool[]", doc="converted numbers, in the shape of `value`")


class ToInt(Conversion, type="omni.graph.nodes.ToInt"):
    """Converts numbers to 32 bit integers; real numbers are truncated toward 0, numbers out of range wrap around."""

    base = "int"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array to convert")
    converted: Any = Out(type=_tuples("int"), doc="converted numbers, in the shape of `value`")


class ToInt64(ScalarConversion, type="omni.graph.nodes.ToInt64"):
    """Converts numbers to 64 bit integers; real numbers are truncated toward 0, numbers out of range wrap around."""

    base = "int64"

    converted: Any = Out(type="int64|int64[]", doc="converted numbers, in the shape of `value`")


class ToUint(ScalarConversion, type="omni.graph.nodes.ToUint"):
    """Converts numbers to unsigned 32 bit integers; real numbers are truncated toward 0, and -1 becomes 2^32 - 1."""

    base = "uint"

    converted: Any = Out(type="uint|uint[]", doc="converted numbers, in the shape of `value`")


class ToUint64(ScalarConversion, type="omni.graph.nodes.ToUint64"):
    """Converts numbers to unsigned 64 bit integers; real numbers are truncated toward 0, and -1 becomes 2^64 - 1."""

    base = "uint64"

    converted: Any = Out(type="uint64|uint64[]", doc="converted numbers, in the shape of `value`")


class ToUchar(Conversion, type="omni.graph.nodes.ToUchar"):
    """Converts numbers to unsigned 8 bit integers, truncated toward 0; -1 becomes 255. A string becomes its UTF-8 bytes."""

    base = "uchar"

    value: Any = In(type=f"{_SCALARS}|string", required=True, doc="number, array of numbers or string to convert")
    converted: Any = Out(type="uchar|uchar[]", doc="converted numbers, in the shape of `value`")


class ToHalf(RoledConversion, type="omni.graph.nodes.ToHalf"):
    """Converts numbers to 16 bit real numbers; numbers with a magnitude of 65520 or more become infinite."""

    base = "half"

    role: Token = In(default="None", tokens=_HALF_ROLES, doc=_ROLE)
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array to convert")
    converted: Any = Out(type=_with_roles("half"), doc="converted numbers, in the shape of `value`")


class ToFloat(RoledConversion, type="omni.graph.nodes.ToFloat"):
    """Converts numbers to 32 bit real numbers, rounded to the nearest one."""

    base = "float"

    role: Token = In(
        default="None", tokens=("None", "Color", "Normal", "Point", "Quaternion", "TexCoord", "Vector"), doc=_ROLE
    )
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array to convert")
    converted: Any = Out(type=_with_roles("float"), doc="converted numbers, in the shape of `value`")


class ToDouble(Conversion, type="omni.graph.nodes.ToDouble"):
    """Converts numbers to 64 bit real numbers."""

    base = "double"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array to convert")
    converted: Any = Out(type=_tuples("double"), doc="converted numbers, in the shape of `value`")

    def compute(self) -> None:
        """Set the output to the converted value. Scalars are converted without numpy: numpy takes fifty times as long."""
        if isinstance(self.value, int | float):
            self.converted = float(self.value)
        else:
            super().compute()


class TextConversion(Node):
    """Base class of nodes that format a value as text."""

    value: Any = In(required=True, doc="value of any type")
    converted: str

    def compute(self) -> None:
        """Set the output to the value as text."""
        self.converted = text_of(self.value)


class ToString(TextConversion, type="omni.graph.nodes.ToString"):
    """Formats a value as a string.

    Real numbers have six significant digits, as in C++. Tuples and arrays are written as Python lists, with quotation marks
    around strings. A uchar[] array is decoded as UTF-8.
    """

    converted: String = Out(doc="`value` as text")


class ToToken(TextConversion, type="omni.graph.nodes.ToToken"):
    """Formats a value as a token, in the format of ToString."""

    converted: Token = Out(doc="`value` as text")


def text_of(value: Any) -> str:
    """Return a port value as text, in the format of the node ToString."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray):
        return bytes(value).decode(errors="replace") if value.dtype == np.uint8 else text_of(value.tolist())
    if isinstance(value, tuple | list):
        items = [f'"{item}"' if isinstance(item, str) else text_of(item) for item in value]
        return f"[{', '.join(items)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


class ToTarget(Node, type="omni.graph.nodes.ToTarget"):
    """Converts prim paths to a target (a list of prims)."""

    value: Any = In(type="path|string|token|token[]", required=True, doc="prim path or paths; empty paths are left out")
    converted: Target = Out(doc="the prims at these paths")

    def compute(self) -> None:
        """Set the output to the prims at the paths, without empty paths.

        Raises:
            TypeError: the value is not a string or a list of strings.
        """
        self.converted = types.coerce(self.value, types.TARGET)
