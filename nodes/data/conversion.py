"""Values as another type (`omni.graph.nodes`). Unlike what wires do by themselves, these may lose something."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from graphengine.node import BadValueError, In, Node, Out, types
from graphengine.node.types import PortType, String, Target, Token, UnionType, plain
from graphengine.nodes.data.broadcast import type_of
from graphengine.nodes.data.unions import PLAIN_NUMERICS, with_arrays, with_roles

_SCALARS = with_arrays("bool|int|int64|uint64|uint|uchar|double|float|half")
_NUMBERS = f"{PLAIN_NUMERICS}|bool|bool[]"
_ROLES = {"Color": "color", "Normal": "normal", "Point": "point", "Quaternion": "quat", "TexCoord": "texcoord"}
_ROLES |= {"Vector": "vector", "Frame": "frame", "Timecode": "", "None": ""}
_HALF_ROLES = ("None", "Color", "Frame", "Normal", "Point", "Quaternion", "TexCoord", "Timecode", "Vector")


def _tuples(base: str) -> str:
    return with_arrays("|".join((base, *(f"{base}[{count}]" for count in (2, 3, 4)))))


def _with_roles(base: str) -> str:
    return f"{_tuples(base)}|{with_arrays(with_roles(base[0]))}"


class Conversion(Node):
    """A node that gives a value's numbers another type and leaves its shape."""

    base: ClassVar[str]

    value: Any
    converted: Any

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """The shape of the value, with the node's own type of numbers."""
        return {"converted": self.result_type(known["value"])} if "value" in known else {}

    def result_type(self, given: PortType) -> PortType:
        """The type of a value of a type, converted."""
        return PortType(self.base, given.count, given.array or given.base == "string")

    def compute(self) -> None:
        """Convert.

        Raises:
            BadValueError: a number has no counterpart in the other type.
        """
        value = np.frombuffer(self.value.encode(), np.uint8) if isinstance(self.value, str) else self.value
        given = self.settled.get("value") or type_of(self.value)
        result = numbers(np.asarray(value, None if isinstance(value, np.ndarray) else given.dtype), self.base)
        self.converted = result if isinstance(value, np.ndarray) else plain(result)


def numbers(array: np.ndarray[Any, Any], base: str) -> np.ndarray[Any, Any]:
    """Numbers of another type: real ones are cut off towards 0, whole ones that do not fit wrap around as in C.

    Raises:
        BadValueError: a real number is too large, or NaN.
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


class RoledConversion(Conversion):
    """A conversion to real numbers, which can be given a role; one that has no tuples of that length gives none."""

    role: Token

    def result_type(self, given: PortType) -> PortType:
        """The shape of the value, with the role that was asked for."""
        bare, role = super().result_type(given), _ROLES[self.role]
        wanted, legal = replace(bare, role=role), type(self).fields["converted"].type
        assert isinstance(legal, UnionType)
        return wanted if wanted in legal.alternatives else bare


class ScalarConversion(Conversion):
    """A conversion of single numbers and arrays of them, without tuples."""

    value: Any = In(type=_SCALARS, required=True, doc="number, or an array of them")


class ToBool(ScalarConversion, type="omni.graph.nodes.ToBool"):
    """False for 0 and true for every other number."""

    base = "bool"

    converted: Any = Out(type="bool|bool[]", doc="of the value's shape")


class ToInt(Conversion, type="omni.graph.nodes.ToInt"):
    """Numbers as 32 bit integers: cut off towards 0, and wrapped around where they are too large."""

    base = "int"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_tuples("int"), doc="of the value's shape")


class ToInt64(ScalarConversion, type="omni.graph.nodes.ToInt64"):
    """Numbers as 64 bit integers: cut off towards 0."""

    base = "int64"

    converted: Any = Out(type="int64|int64[]", doc="of the value's shape")


class ToUint(ScalarConversion, type="omni.graph.nodes.ToUint"):
    """Numbers as 32 bit integers without a sign: cut off towards 0; -1 is 2^32 - 1."""

    base = "uint"

    converted: Any = Out(type="uint|uint[]", doc="of the value's shape")


class ToUint64(ScalarConversion, type="omni.graph.nodes.ToUint64"):
    """Numbers as 64 bit integers without a sign: cut off towards 0; -1 is 2^64 - 1."""

    base = "uint64"

    converted: Any = Out(type="uint64|uint64[]", doc="of the value's shape")


class ToUchar(Conversion, type="omni.graph.nodes.ToUchar"):
    """Numbers as 8 bit integers without a sign: cut off towards 0; -1 is 255. Of a text, its UTF-8 bytes."""

    base = "uchar"

    value: Any = In(type=f"{_SCALARS}|string", required=True, doc="number, an array of them, or a text")
    converted: Any = Out(type="uchar|uchar[]", doc="of the value's shape")


class ToHalf(RoledConversion, type="omni.graph.nodes.ToHalf"):
    """Numbers rounded to 16 bit real numbers; from 65520 on they are infinite."""

    base = "half"

    role: Token = In(default="None", tokens=_HALF_ROLES)
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_with_roles("half"), doc="of the value's shape")


class ToFloat(RoledConversion, type="omni.graph.nodes.ToFloat"):
    """Numbers rounded to 32 bit real numbers."""

    base = "float"

    role: Token = In(default="None", tokens=("None", "Color", "Normal", "Point", "Quaternion", "TexCoord", "Vector"))
    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_with_roles("float"), doc="of the value's shape")


class ToDouble(Conversion, type="omni.graph.nodes.ToDouble"):
    """Numbers as 64 bit real numbers."""

    base = "double"

    value: Any = In(type=_NUMBERS, required=True, doc="number, tuple or array")
    converted: Any = Out(type=_tuples("double"), doc="of the value's shape")

    def compute(self) -> None:
        """Convert; one number without numpy, which takes fifty times as long."""
        if isinstance(self.value, int | float):
            self.converted = float(self.value)
        else:
            super().compute()


class TextConversion(Node):
    """A node that writes a value as text."""

    value: Any = In(required=True, doc="of any type")
    converted: str

    def compute(self) -> None:
        """Write."""
        self.converted = text_of(self.value)


class ToString(TextConversion, type="omni.graph.nodes.ToString"):
    """A value as text.

    Real numbers have six digits, as in C++; tuples and arrays are written as Python lists, an array of texts with quotation
    marks. A uchar[] is the text that its bytes make.
    """

    converted: String = Out(doc="the text")


class ToToken(TextConversion, type="omni.graph.nodes.ToToken"):
    """A value as a token, with the text that ToString gives."""

    converted: Token = Out(doc="the text")


def text_of(value: Any) -> str:
    """A port's value as text."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray):
        return bytes(value).decode(errors="replace") if value.dtype == np.uint8 else text_of(value.tolist())
    if isinstance(value, tuple | list):
        items = [f'"{item}"' if isinstance(item, str) else text_of(item) for item in value]
        return f"[{', '.join(items)}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


class ToTarget(Node, type="omni.graph.nodes.ToTarget"):
    """Prim paths as a target."""

    value: Any = In(type="path|string|token|token[]", required=True, doc="a path, or several; empty for no prim")
    converted: Target = Out(doc="the prims")

    def compute(self) -> None:
        """Take the paths.

        Raises:
            TypeError: not texts.
        """
        self.converted = types.coerce(self.value, types.TARGET)
