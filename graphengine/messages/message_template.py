"""Encodes messages of constant size by patching numbers into the bytes of an earlier message.

Most messages of a topic differ only in numbers: frame IDs, the number of transforms and the size of images stay the same. For
such messages it is enough to pack the numbers into the bytes of the earlier message; the encoder is not needed. A large array
is copied only once: the bytes before and after the array are separate pieces, and all pieces and arrays are joined at the end.
"""

from __future__ import annotations

import struct
from bisect import bisect
from collections.abc import Callable
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import SCALARS

_CODES = {kind: code.removeprefix("<") for kind, code in SCALARS.items()}

MAX_PATCHED = 1024
"""Maximum size of an array that is patched, bytes; a larger array is joined with the pieces around it, which copies less."""

_HEADER = 4
"""Size of the CDR encapsulation header, bytes; alignment is relative to the end of this header."""


class _NoTemplateError(Exception):
    """A message type has a field for which templates are not supported, such as a wide string."""


class Template:
    """An encoded message, with the byte offset of each number.

    Another message with the same strings and array lengths is encoded by writing its numbers at these offsets.

    Args:
        message: message from which the template is made.
        definitions: definitions of all known message types.
        checked: whether the function `encode` also compares the classes of nested messages and the layout of arrays.
    """

    def __init__(self, message: Any, definitions: Definitions = DEFINITIONS, *, checked: bool = False) -> None:
        self._definitions, self._checked = definitions, checked
        self._offset = _HEADER
        self.numbers: list[tuple[int, str, str]] = []
        """Offset in the bytes, `struct` format character, and Python expression in the message `m` of each number."""
        self._constants: list[tuple[str, Any]] = []
        self._arrays: list[tuple[int, int, str]] = []
        """Begin and end offset in the bytes, and Python expression in the message `m` of each array."""
        self._walk(message, messages.message_type(message), "m")
        self.encode = self._compile(messages.encode(message, definitions))
        """Function that returns the bytes of a message, or None if the message differs from the template in more than numbers.

        It raises an error if a field has the wrong type."""

    @staticmethod
    def of(message: Any, definitions: Definitions = DEFINITIONS, *, checked: bool = False) -> Template | None:
        """Return a template made from a message; None if templates do not support the message's type."""
        try:
            template = Template(message, definitions, checked=checked)
        except _NoTemplateError:
            return None
        return template if template.encode(message) == messages.encode(message, definitions) else None

    @property
    def only_numbers(self) -> bool:
        """Whether the message consists of numbers and of messages of numbers, without strings, arrays and sequences."""
        return not self._constants and not self._arrays

    def _align(self, size: int) -> None:
        self._offset += -(self._offset - _HEADER) % size

    def _walk(self, message: Any, message_type: str, path: str) -> None:
        for name, (kind, detail) in self._definitions.fields(message_type):
            value, place = getattr(message, name), f"{path}.{name}"
            if kind == Nodetype.BASE:
                self._base(value, detail[0], place)
            elif kind == Nodetype.NAME:
                if self._checked:
                    self._constants.append((f"{place}.__class__", type(value)))
                self._walk(value, detail, place)
            elif kind == Nodetype.ARRAY and detail[0][0] == Nodetype.BASE:
                self._array(value, detail[0][1][0], place)
            elif kind == Nodetype.SEQUENCE and detail[0][0] == Nodetype.NAME:
                self._align(4)
                self._offset += 4
                self._constants.append((f"len({place})", len(value)))
                for index, item in enumerate(value):
                    self._walk(item, detail[0][1], f"{place}[{index}]")
            elif kind == Nodetype.SEQUENCE:
                self._sequence(value, detail[0][1][0], place)
            else:
                raise _NoTemplateError(place)

    def _base(self, value: Any, kind: str, place: str) -> None:
        if kind == "string":
            self._align(4)
            self._offset += 4 + len(value.encode()) + 1
            self._constants.append((place, value))
            return
        code = _CODES.get(kind)
        if code is None:
            raise _NoTemplateError(place)
        size = struct.calcsize(code)
        self._align(size)
        self.numbers.append((self._offset, code, place))
        self._offset += size

    def _sequence(self, value: Any, kind: str, place: str) -> None:
        """Add a sequence; its strings become constants of the template, its numbers are patched."""
        self._align(4)
        self._offset += 4
        if kind == "string":
            for text in value:
                self._align(4)
                self._offset += 4 + len(text.encode()) + 1
            self._constants.append((place, list(value)))  # a copy: the list itself may be changed
        else:
            self._array(value, kind, place)

    def _array(self, value: Any, kind: str, place: str) -> None:
        """Add an array of numbers, which are patched; its type and length become constants of the template."""
        if not isinstance(value, np.ndarray) or kind not in _CODES:
            raise _NoTemplateError(place)
        self._constants += [(f"{place}.shape", value.shape), (f"{place}.dtype", value.dtype)]
        if self._checked:
            self._constants.append((f"{place}.flags.c_contiguous", True))
        if value.nbytes:
            self._align(value.itemsize)
            self._arrays.append((self._offset, self._offset + value.nbytes, place))
            self._offset += value.nbytes

    def _compile(self, data: bytes) -> Callable[[Any], bytes | None]:
        """Return the generated `encode` function.

        The function compares each constant, packs each run of numbers without gaps, and copies each array.

        Args:
            data: bytes of the message from which the template is made; the function patches copies of the pieces around large
                arrays.
        """
        runs = self._runs()
        large = [(begin, end) for begin, end, _ in self._arrays if end - begin > MAX_PATCHED]
        starts, ends = [0, *(end for _, end in large)], [*(begin for begin, _ in large), len(data)]
        names: dict[str, Any] = {f"c{i}": value for i, (_, value) in enumerate(self._constants)}
        names |= {f"p{i}": struct.Struct(code).pack_into for i, (_, code, _) in enumerate(runs)}
        names |= {f"b{i}": bytearray(data[start:end]) for i, (start, end) in enumerate(zip(starts, ends, strict=True))}

        def place_of(offset: int) -> tuple[str, int]:
            piece = bisect(starts, offset) - 1
            return f"b{piece}", offset - starts[piece]

        lines, parts = [self._comparison()], ["b0"]
        for index, (offset, _, values) in enumerate(runs):
            piece, begin = place_of(offset)
            lines.append(f"p{index}({piece}, {begin}, {', '.join(values)})")
        for start, end, value in self._arrays:
            if (start, end) in large:
                parts += [value, place_of(end)[0]]
            else:
                piece, begin = place_of(start)
                lines.append(f"{piece}[{begin}:{begin + end - start}] = {value}.tobytes()")
        lines.append(f"return b''.join(({', '.join(parts)}))" if large else "return bytes(b0)")
        head = f"def encode({', '.join(['m', *(f'{name}={name}' for name in names)])}):"
        exec("\n    ".join([head, *lines]), names)  # our own text: names in it are fields of ROS's definitions
        encode: Callable[[Any], bytes | None] = names["encode"]
        return encode

    def _comparison(self) -> str:
        """Return the line of the generated function that returns None if a constant differs; dtypes are compared by identity."""
        operators = ["is not" if isinstance(value, np.dtype | type) else "!=" for _, value in self._constants]
        different = [f"{place} {operators[i]} c{i}" for i, (place, _) in enumerate(self._constants)]
        return f"if {' or '.join(different)}: return None" if different else ""

    def _runs(self) -> list[tuple[int, str, list[str]]]:
        """Group adjacent numbers, so that one `struct.pack_into` call packs a group.

        Return the offset, the `struct` format and the Python expressions of each group.
        """
        runs: list[tuple[int, str, list[str]]] = []
        end = -1
        for offset, code, place in self.numbers:
            if offset == end:
                first, codes, places = runs[-1]
                runs[-1] = (first, codes + code, [*places, place])
            else:
                runs.append((offset, f"<{code}", [place]))
            end = offset + struct.calcsize(code)
        return runs


class Encoder:
    """Encodes the messages of one topic: similar messages with a template, other messages with the general encoder.

    Args:
        definitions: definitions of all known message types.
        checked: whether to check all fields of each message; needed for messages of users.
    """

    PATIENCE = 8
    """Maximum number of templates for a topic. The general encoder encodes messages that do not fit the last template."""

    def __init__(self, definitions: Definitions = DEFINITIONS, *, checked: bool = False) -> None:
        self._definitions, self._checked = definitions, checked
        self._template: Template | None = None
        self._left = self.PATIENCE

    def encode(self, message: Any) -> bytes:
        """Return the message as CDR bytes.

        Raises:
            MessageError: a field has the wrong type.
        """
        if self._template is not None:
            try:
                data = self._template.encode(message)
            except (AttributeError, IndexError, OverflowError, TypeError, ValueError, struct.error):
                data = None  # the general encoder reports the fault
            if data is not None:
                return data
        if self._checked:
            messages.check(message, self._definitions)
        data = messages.encode(message, self._definitions)
        if self._left:
            self._left -= 1
            self._template = Template.of(message, self._definitions, checked=self._checked)
            if self._template is None:
                self._left = 0
        return data
