"""Parses messages from YAML, as `ros2 topic pub` does; missing fields get their default values.

The words `auto`, as the value of a header, and `now`, as the value of a time, mean the time at which the message is sent.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Value
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import TEXTS, signed_byte
from graphengine.messages.plain import Maker

HEADER = "std_msgs/msg/Header"
TIME = "builtin_interfaces/msg/Time"

_YES, _NO = ("yes", "Yes", "YES", "on", "On", "ON"), ("no", "No", "NO", "off", "Off", "OFF")
"""Words that mean true or false in YAML 1.1, the version that ros2cli reads."""


class _InvalidValueError(Exception):
    """A value does not fit its field; the error was already added to the findings."""


@dataclass(frozen=True, slots=True)
class Draft:
    """A parsed message, and a list of its times that are set when the message is sent."""

    message: Any
    stamps: list[Any]
    """The builtin_interfaces/Time objects within `message` that are set to the time of sending."""

    def stamp(self, nanoseconds: int) -> Any:
        """Set the times in `stamps` to a time in ns, since 1970 or since the simulation began; return the message."""
        for stamp in self.stamps:
            stamp.sec, stamp.nanosec = divmod(nanoseconds, 1_000_000_000)
        return self.message


def parse(text: str, message_type: str, definitions: Definitions = DEFINITIONS) -> Draft:
    """Parse a message of a type from YAML.

    Raises:
        CheckError: the text is not a message of the type; the findings give positions in the text.
        MessageTypeError: the type is unknown.
    """
    definitions.message_class(message_type)
    findings = Findings()
    given = document.parse(text, "message", findings)
    findings.raise_errors()
    assert given is not None
    reader = _MessageReader(definitions, findings)
    try:
        return Draft(reader.message(given.root, message_type, message_type), reader.stamps)
    except _InvalidValueError:
        findings.raise_errors()
        raise


def full_type(name: str, folder: str = "msg") -> str:
    """Return the full name of a type from its short name: `geometry_msgs/msg/Twist` for `geometry_msgs/Twist`."""
    return re.sub(r"\A([^/]+)/([^/]+)\Z", rf"\1/{folder}/\2", name)


class _MessageReader(Maker):
    """Builds messages from YAML values."""

    shorthands = MappingProxyType({HEADER: "auto", TIME: "now"})

    def __init__(self, definitions: Definitions, findings: Findings) -> None:
        super().__init__(definitions)
        self.stamps: list[Any] = []
        self._findings = findings

    def message(self, given: Value, message_type: str, place: str) -> Any:
        """Return the message for a YAML mapping, or for the word `auto` (for a Header) or `now` (for a Time)."""
        if isinstance(given.data, str) and given.data == self.shorthands.get(message_type):
            message = self.definitions.initial(message_type)
            self.stamps.append(message.stamp if message_type == HEADER else message)
            return message
        return super().message(given, message_type, place)

    def data(self, given: Value) -> Any:
        """Return the plain data of a YAML value, without its position."""
        return given.data

    def place_of(self, name: str, place: str) -> str:
        """Return the field's name only, because errors also have line and column."""
        return name

    def scalar(self, given: Value, name: str) -> Any:
        """Convert a YAML scalar to the field type `name`, with the rules of YAML 1.1; a value that does not fit is kept."""
        data = given.data
        if name in TEXTS and isinstance(data, bool | int | float):
            return _as_written(given)
        if name == "bool":
            return True if data in _YES or data == 1 else False if data in _NO or data == 0 else data
        if name in ("float32", "float64"):
            return _number(data)
        if isinstance(data, float) and data.is_integer():
            return int(data)
        return signed_byte(data) if name == "byte" and isinstance(data, int) and 127 < data < 256 else data

    def refused(
        self, code: str, what: str, given: Value, place: str = "", key: Any = None, hint: str = ""
    ) -> Exception:
        """Add a finding at the position of the value; return the exception to raise."""
        self._findings.add(code, what, given.span if key is None else given.keys[key], hint)
        return _InvalidValueError()


def _as_written(given: Value) -> str:
    """Return the text of a scalar that YAML reads as a number or boolean, for a field that is a string."""
    span = given.span
    return span.source.lines[span.line - 1][span.column - 1 : span.column - 1 + span.length]


def _number(data: Any) -> Any:
    """Convert a number, or a string such as `nan`, to a float; return any other value unchanged."""
    try:
        return data if isinstance(data, bool) else float(data)
    except (TypeError, ValueError, OverflowError):
        return data
