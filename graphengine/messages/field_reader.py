"""Generates functions that read one number of an encoded message in less than 1 us, without decoding the message."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

from rosbags.interfaces import Nodetype

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import SCALARS, Description, element_of

_HEADER = 4
"""Size of the CDR encapsulation header, bytes; alignment is relative to the end of this header."""


def number_reader(
    message_type: str, path: str, definitions: Definitions = DEFINITIONS
) -> Callable[[bytes], float] | None:
    """Return a function that reads a number of a message in CDR bytes; None if the message has no such number.

    >>> read = number_reader("geometry_msgs/msg/PointStamped", "point.y")
    >>> point = messages.Point(1.0, 2.0, 3.0)
    >>> read(messages.encode(messages.message_class("geometry_msgs/msg/PointStamped")(messages.header(0.5, "odom"), point)))
    2.0

    The function returns the value that `messages.decode` gives, and raises its errors. It decodes messages in big endian, and
    messages whose layout it cannot compute, such as those with a sequence of messages.

    Args:
        message_type: name of the message type.
        path: names of the field and of the messages around it, such as `twist.twist.linear.x`.
        definitions: message types.
    """
    layout = _Layout(definitions)
    layout.add((Nodetype.NAME, message_type), path.split("."))
    return layout.reader(lambda data: attrgetter(path)(messages.decode(data, message_type, definitions)))


class _Layout:
    """Statements that compute the positions of the fields of a message, in which `p` is a position in the bytes `data`."""

    def __init__(self, definitions: Definitions) -> None:
        self._definitions = definitions
        self._lines: list[str] = []
        self._offset = 0
        """Distance of the next field from `p`, bytes."""
        self._aligned = 8
        """Largest power of two, up to 8, that divides `p` for certain."""
        self._unpack: Callable[..., Any] | None = None
        self._is_known = True
        """Whether all positions up to here can be computed."""

    def add(self, description: Description, wanted: Sequence[str] | None = None) -> None:
        """Add a field; `wanted` is the path of the number in this field, None if the number is in another field."""
        kind, detail = description
        if kind == Nodetype.NAME:
            for name, field in self._definitions.fields(detail):
                self.add(field, wanted[1:] if wanted and wanted[0] == name else None)
        elif kind == Nodetype.BASE and detail[0] == "string":
            self._jump("p += n")
            self._aligned = 1
        elif _scalar(description) not in SCALARS:
            self._is_known = False
        elif kind == Nodetype.BASE:
            size = self._align(detail[0])
            if wanted is not None and not wanted:
                self._unpack = struct.Struct(SCALARS[detail[0]]).unpack_from
                self._lines.append(f"number, = unpack(data, p + {self._offset + _HEADER})")
            self._offset += size
        elif kind == Nodetype.ARRAY:
            self._offset += self._align(_scalar(description)) * detail[1]
        else:
            size = struct.calcsize(SCALARS[_scalar(description)])
            self._jump(f"p = ((p + {size - 1} & {-size}) if n else p) + n * {size}")
            self._aligned = min(size, 4)

    def _align(self, kind: str) -> int:
        """Align the next field to the size of a number, and return this size, bytes."""
        size = struct.calcsize(SCALARS[kind])
        if size > self._aligned:
            self._lines.append(f"p = p + {self._offset + size - 1} & {-size}")
            self._offset, self._aligned = 0, size
        self._offset += -self._offset % size
        return size

    def _jump(self, statement: str) -> None:
        """Read the length `n` of a string or sequence, and move `p` to its end."""
        self._align("uint32")
        self._lines += [f"n, = length(data, p + {self._offset + _HEADER})", f"p += {self._offset + 4}", statement]
        self._offset = 0

    def reader(self, decode: Callable[[bytes], Any]) -> Callable[[bytes], float] | None:
        """Return the function that reads the number, or calls `decode` for big-endian and malformed messages."""
        if self._unpack is None or not self._is_known:
            return None if self._unpack is None else decode
        lines = ["p = 0", *self._lines, f"if p + {self._offset + _HEADER} <= len(data): return number"]
        head = ["def read(data):", f" if data[:2] == {messages.LITTLE_ENDIAN!r}:", "  try:"]
        source = "\n".join([*head, *(f"   {line}" for line in lines), "  except error: pass", " return decode(data)"])
        length = struct.Struct("<I").unpack_from
        names: dict[str, Any] = {"unpack": self._unpack, "length": length, "decode": decode, "error": struct.error}
        exec(source, names)
        read: Callable[[bytes], float] = names["read"]
        return read


def _scalar(description: Description) -> str:
    """Return the name of a number type, or of the number type of an array; empty for a message type."""
    kind, detail = element_of(description)
    return str(detail[0]) if kind == Nodetype.BASE else ""
