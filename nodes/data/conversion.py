"""Type conversions (`omni.graph.nodes`). Unlike the conversion that a wire does, they can lose information."""

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
    """Base of nodes that convert the numbers of a value and keep its shape."""

    base: ClassVar[str]

    value: Any
    converted: Any

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the output: the node's number type in the shape of the value."""
        return {"converted": self.result_type(known["value"])} if "value" in known else {}

    def result_type(self, given: PortType) -> PortType:
        """Return the output type for an input type."""
        return PortType(self.base, given.count, given.array or given.base == "string")

    def compute(self) -> None:
        """Convert the value.

        Raises:
            BadValueError: the output type cannot represent a number.
        """
        value = np.frombuffer(self.value.encode(), np.uint8) if isinstance(self.value, str) else self.value
        given = self.settled.get("value") or type_of(self.value)
        result = numbers(np.asarray(value, None if isinstance(value, np.ndarray) else given.dtype), self.base)
        self.converted = result if isinstance(value, np.ndarray) else plain(result)


def numbers(array: np.ndarray[Any, Any], base: str) -> np.ndarray[Any, Any]:
    """Convert numbers to another base type.

    For integer types, real numbers are truncated toward 0; numbers out of range wrap around as in C.

    Raises:
        BadValueError: a real number that is to become an integer of n bits is NaN, or its magnitude is 2^n or more.
    """
    dtype = PortType(base).dtype
    if array.dtype.kind == "f" and np.dtype(dtype).kind in "iu":
        whole, bits = np.trunc(array.astype(np.float64)), np.iinfo(dtype).bits
        wrong = whole[~(np.abs(whole) < 2.0**bits)]
        if wrong.size:
            raise BadValueError("value", float(wrong.flat[0]), f"a number that a {base} can hold")
        wrapped = [int(number) % 2**bits for number in whole.ravel().tolist()]
        return np.array(wrapped, np.uint64).reshape(array.shape).astype(dtype)
    with np.errstate(over="ignore"):
        return array.astype(dtype)


_ROLE = "role of the output; ignored if it has no tuples of the value's length"


class RoledConversion(Conversion):
    """Base of nodes that convert to real numbers. The output has the chosen role if the role has tuples of the value's length."""

    role: Token

    def result_type(self, given: PortType) -> PortType:
        """Return the output type for an input type, with the chosen role if it has tuples of that length."""
        bare, role = super().result_type(given), _ROLES[self.role]
        wanted, legal = replace(bare, role=role), type(self).fields["converted"].type
        assert isinstance(legal, UnionType)
        return wanted if wanted in legal.alternatives else bare


class ScalarConversion(Conversion):
    """Base of conversions that accept numbers and arrays of numbers, but no tuples."""

    value: Any = In(type=_SCALARS, required=True, doc="number, or array of numbers")


class ToBool(ScalarConversion, type="omni.graph.nodes.ToBool"):
    """Numbers as booleans: false for 0, true for every other number."""

    base = "bool"

    converted: Any = Out(type="bool|bool[]", doc="converted value, of the same shape")


class ToInt(Conversion, type="omni.graph.nodes.ToInt"):
    """Numbers as 32 bit integers: real numbers are truncated toward 0, integers wrap around."""

    base = "int"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_tuples("int"), doc="converted value, of the same shape")


class ToInt64(ScalarConversion, type="omni.graph.nodes.ToInt64"):
    """Numbers as 64 bit integers; real numbers are truncated toward 0."""

    base = "int64"

    converted: Any = Out(type="int64|int64[]", doc="converted value, of the same shape")


class ToUint(ScalarConversion, type="omni.graph.nodes.ToUint"):
    """Numbers as unsigned 32 bit integers; real numbers are truncated toward 0, -1 becomes 2^32 - 1."""

    base = "uint"

    converted: Any = Out(type="uint|uint[]", doc="converted value, of the same shape")


class ToUint64(ScalarConversion, type="omni.graph.nodes.ToUint64"):
    """Numbers as unsigned 64 bit integers; real numbers are truncated toward 0, -1 becomes 2^64 - 1."""

    base = "uint64"

    converted: Any = Out(type="uint64|uint64[]", doc="converted value, of the same shape")


class ToUchar(Conversion, type="omni.graph.nodes.ToUchar"):
    """Numbers as unsigned 8 bit integers, truncated toward 0; -1 becomes 255. A string becomes its UTF-8 bytes."""

    base = "uchar"

    value: Any = In(type=f"{_SCALARS}|string", required=True, doc="number, array of numbers, or string")
    converted: Any = Out(type="uchar|uchar[]", doc="converted value, of the same shape")


class ToHalf(RoledConversion, type="omni.graph.nodes.ToHalf"):
    """Numbers rounded to 16 bit real numbers; numbers from 65520 on become infinite."""

    base = "half"

    role: Token = In(default="None", tokens=_HALF_ROLES, doc=_ROLE)
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_with_roles("half"), doc="converted value, of the same shape")


class ToFloat(RoledConversion, type="omni.graph.nodes.ToFloat"):
    """Numbers rounded to 32 bit real numbers."""

    base = "float"

    role: Token = In(
        default="None", tokens=("None", "Color", "Normal", "Point", "Quaternion", "TexCoord", "Vector"), doc=_ROLE
    )
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_with_roles("float"), doc="converted value, of the same shape")


class ToDouble(Conversion, type="omni.graph.nodes.ToDouble"):
    """Numbers as 64 bit real numbers."""

    base = "double"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_tuples("double"), doc="converted value, of the same shape")

    def compute(self) -> None:
        """Convert the value; scalars without numpy, which is fifty times slower."""
        if isinstance(self.value, int | float):
            self.converted = float(self.value)
        else:
            super().compute()


class TextConversion(Node):
    """Base of nodes that format a value as text."""

    value: Any = In(required=True, doc="value of any type")
    converted: str

    def compute(self) -> None:
        """Format the value."""
        self.converted = text_of(self.value)


class ToString(TextConversion, type="omni.graph.nodes.ToString"):
    """A value as text.

    Real numbers have six significant digits, as in C++. Tuples and arrays are written as Python lists, with quotation marks
    around strings. A uchar[] is decoded as UTF-8 text.
    """

    converted: String = Out(doc="`value` as text")


class ToToken(TextConversion, type="omni.graph.nodes.ToToken"):
    """A value as a token, formatted as by ToString."""

    converted: Token = Out(doc="`value` as text")


def text_of(value: Any) -> str:
    """Return a port's value as text, in the format of ToString."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray):
        return bytes(value).decode(errors="replace") if value.dtype == np.uint8 else text_of(value.tolist())
    if isinstance(value, tuple | list):
        items = [f'"{item}"' if isinstance(item, str) else text_of(item) for item in value]
        return f"[{', '.join(items)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


class ToTarget(Node, type="omni.graph.nodes.ToTarget"):
    """Prim paths as a target, which is a list of prims."""

    value: Any = In(type="path|string|token|token[]", required=True, doc="prim path or paths; empty for no prim")
    converted: Target = Out(doc="the prims at these paths")

    def compute(self) -> None:
        """Convert the paths.

        Raises:
            TypeError: the value is not a string or a list of strings.
        """
        self.converted = types.coerce(self.value, types.TARGET)
