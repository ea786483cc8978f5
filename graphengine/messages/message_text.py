"""Formats messages as text, in the same forms as ros2cli: YAML, comma-separated values, and Python expressions."""

from __future__ import annotations

import array
import functools
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from graphengine.format.errors import TransportError
from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import SCALARS, TEXTS, Description, element_of, named

_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float", "float64": "double"}
"""A dict from ROS names of number types to IDL names, which ros2cli prints as element types of arrays."""
_WIDTH = 2**31 - 1
_CUT = "..."


_MAP = "tag:yaml.org,2002:map"


@dataclass(frozen=True, slots=True)
class TypedValue:
    """A message, or the value of a message field, together with its type.

    Args:
        value: message object, array, list or scalar, as rosbags represents it.
        kind: type of the value.
        definitions: definitions of all known message types.
    """

    value: Any
    kind: Description
    definitions: Definitions = field(default=DEFINITIONS, repr=False)

    @staticmethod
    def of(message: Any, definitions: Definitions = DEFINITIONS) -> TypedValue:
        """Return a message together with its type."""
        return TypedValue(message, named(message.__msgtype__), definitions)

    @property
    def is_message(self) -> bool:
        """Whether the value is a message."""
        return bool(self.kind[0] == Nodetype.NAME)

    @property
    def is_array(self) -> bool:
        """Whether the value is an array of fixed or variable length."""
        return self.kind[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE)

    @property
    def scalar(self) -> str:
        """ROS type of a scalar or of an array's elements, such as `float64`; empty for a message or an array of messages."""
        kind, detail = element_of(self.kind)
        return str(detail[0]) if kind == Nodetype.BASE else ""

    def fields(self) -> Iterator[tuple[str, TypedValue]]:
        """Yield the fields of a message with their ROS names."""
        message_type = self.kind[1]
        attributes = (attribute for attribute, _ in self.definitions.fields(message_type))
        for attribute, (name, kind) in zip(attributes, self.definitions.definition(message_type).fields, strict=True):
            yield name, TypedValue(getattr(self.value, attribute), kind, self.definitions)

    def elements(self) -> Iterator[TypedValue]:
        """Yield the elements of an array."""
        values = self.value.tolist() if isinstance(self.value, np.ndarray) else self.value
        return (TypedValue(value, self.kind[1][0], self.definitions) for value in values)

    def find(self, path: str) -> TypedValue:
        """Return the value at a path of field names, such as `pose.pose.position`.

        Raises:
            TransportError: a name in the path is not the name of a field.
        """
        part = self
        for name in filter(None, path.split(".")):
            below = dict(part.fields()) if part.is_message else {}
            if name not in below:
                hint = did_you_mean(name, below) or listing(below, "fields")
                raise TransportError(f"no field {name!r} in {path!r}\n{hint}")
            part = below[name]
        return part


@dataclass(frozen=True, slots=True)
class Style:
    """Options for printing messages.

    Args:
        longest: maximum length of arrays and strings: longer arrays and strings are cut; None: no limit.
        arrays: whether to print arrays; if false, only their types and lengths are printed.
        texts: whether to print strings; if false, only their lengths are printed.
        flow: whether to print YAML lists in brackets.
        octets: whether to print fields of type `byte` as characters, as rclpy does; if false, as numbers.
    """

    longest: int | None = None
    arrays: bool = True
    texts: bool = True
    flow: bool = False
    octets: bool = True


def to_plain(message: Any, definitions: Definitions = DEFINITIONS) -> dict[str, Any]:
    """Return a message as dicts, lists and scalars, with the fields in the order of the definition.

    Values of type `byte` are numbers from 0 to 255.
    """
    plain: dict[str, Any] = _plain(TypedValue.of(message, definitions), Style(octets=False))
    return plain


def to_yaml(part: TypedValue, style: Style = Style()) -> str:
    """Return a message or value as `ros2 topic echo` prints it, without the line of dashes that separates messages.

    Characters that mislead readers, such as U+202E (it reverses the order of text), are written as escapes of YAML.
    """
    import yaml  # not for the nodes that need `to_plain`

    plain = _plain(part, style)
    text = str(yaml.dump(plain, Dumper=_dumper(), allow_unicode=True, width=_WIDTH, default_flow_style=style.flow))
    return text if text.isascii() else "".join(f"\\U{ord(c):08X}" if _misleads(c) else c for c in text)


@functools.cache
def _dumper() -> Any:
    """Return the class of a YAML dumper that keeps the order of mappings and prints mappings in block style."""
    import yaml

    class Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
        pass

    Dumper.add_representer(dict, lambda dump, data: dump.represent_mapping(_MAP, list(data.items()), flow_style=False))
    Dumper.add_representer(str, _represent)
    Dumper.add_representer(bytes, lambda dump, data: _represent(dump, data.decode("latin-1")))
    return Dumper


def _represent(dump: Any, text: str) -> Any:
    """Return the YAML node of a string, in double quotes if the string has characters that must be written as escapes."""
    style = None if text.isascii() or not any(map(_misleads, text)) else '"'
    return dump.represent_scalar("tag:yaml.org,2002:str", text, style=style)


def _misleads(character: str) -> bool:
    """Return whether a character is invisible or reorders text; the dumper itself escapes control characters."""
    return unicodedata.category(character) in ("Cf", "Cs", "Zl", "Zp")


def to_csv(part: TypedValue, style: Style = Style()) -> str:
    """Return all values of a message on one line, separated by commas; an array that is cut ends with `...`."""
    return ",".join(_cells(_plain(part, style)))


def to_expression(part: TypedValue) -> str:
    """Return a message or value as the Python expression that `ros2 topic pub` prints, such as `std_msgs.msg.Bool(data=True)`."""
    if part.is_message:
        inside = ", ".join(f"{name}={to_expression(value)}" for name, value in part.fields())
        return f"{part.kind[1].replace('/', '.')}({inside})"
    if not part.is_array:
        return repr(_octet(part.value) if part.scalar == "byte" else part.value)
    if part.kind[0] == Nodetype.ARRAY and isinstance(part.value, np.ndarray):
        return repr(part.value)
    return f"[{', '.join(map(to_expression, part.elements()))}]"


def to_plain_text(part: TypedValue) -> str:
    """Return the value of a field as `ros2 topic echo --field` prints it.

    A message is written as a Python expression such as `std_msgs.msg.Bool(data=True)`; other values in Python's notation.
    """
    sequence = part.kind[0] == Nodetype.SEQUENCE
    if part.scalar in ("", "byte") or (sequence and part.scalar in ("bool", *TEXTS)):
        return to_expression(part)
    if sequence:
        return str(array.array(SCALARS[part.scalar].removeprefix("<"), part.value.tolist()))
    return str(part.value)


def _plain(part: TypedValue, style: Style) -> Any:
    """Return a value as dicts, lists and scalars, cut and reduced according to the style."""
    if part.is_message:
        return {name: _plain(value, style) for name, value in part.fields()}
    if not part.is_array:
        return _scalar(part, style)
    if not style.arrays:
        return _summary(part)
    if isinstance(part.value, np.ndarray) and part.scalar != "byte" and style.longest is None:
        return part.value.tolist()
    shown = replace(part, value=part.value[: style.longest])
    cut = [_CUT] if len(shown.value) < len(part.value) else []
    return [_plain(value, style) for value in shown.elements()] + cut


def _cells(plain: Any) -> Iterator[str]:
    """Yield all values in dicts and lists as strings; an empty list yields one empty string."""
    if isinstance(plain, dict | list):
        values = plain.values() if isinstance(plain, dict) else plain or [""]
        yield from (cell for value in values for cell in _cells(value))
    else:
        yield str(plain)


def _scalar(part: TypedValue, style: Style) -> Any:
    """Return a scalar in the representation that the style selects."""
    if part.scalar == "byte":
        return _octet(part.value) if style.octets else part.value & 0xFF
    return _text(part.value, style) if part.scalar in TEXTS else part.value


def _text(text: str, style: Style) -> str:
    if not style.texts:
        return f"<string length: <{len(text)}>>"
    return text if style.longest is None or len(text) <= style.longest else text[: style.longest] + _CUT


def _summary(part: TypedValue) -> str:
    """Return the type and length of an array as the text that ros2cli prints with `--no-arr`."""
    kind, ((element, detail), count) = part.kind
    name = detail if element == Nodetype.NAME else _IDL_NAMES.get(detail[0], detail[0])
    if kind == Nodetype.ARRAY:
        return f"<array type: {name}[{count}]>"
    return f"<sequence type: {name}{f'[{count}]' if count else ''}, length: {len(part.value)}>"


def _octet(value: int) -> bytes:
    """Return a value of type `byte`, which rosbags represents as a signed number, as a `bytes` object."""
    return bytes([value & 0xFF])
