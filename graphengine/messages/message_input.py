"""A message from YAML, as `ros2 topic pub` takes it: what is not given has the value that the definition says.

`auto` for a header and `now` for a time stand for the moment at which the message is sent.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Value
from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages.definitions import DEFINITIONS, Definitions, dtype_of
from graphengine.messages.faults import find_fault
from graphengine.messages.interfaces import TEXTS, Description, named, signed_byte

HEADER = "std_msgs/msg/Header"
TIME = "builtin_interfaces/msg/Time"

_YES, _NO = ("yes", "Yes", "YES", "on", "On", "ON"), ("no", "No", "NO", "off", "Off", "OFF")
"""Texts that ros2cli, which reads YAML 1.1, takes for a boolean."""


class _RefusedError(Exception):
    """A value that does not fit; the finding is added already."""


@dataclass(slots=True)
class Draft:
    """A message that bears the time at which it is sent."""

    message: Any
    stamps: list[Any] = field(default_factory=list)
    """Parts of it that hold that time."""

    def stamp(self, nanoseconds: int) -> Any:
        """The message, with a time since 1970 or since the simulation began."""
        for stamp in self.stamps:
            stamp.sec, stamp.nanosec = divmod(nanoseconds, 1_000_000_000)
        return self.message


def parse(text: str, message_type: str, definitions: Definitions = DEFINITIONS) -> Draft:
    """The message that YAML describes.

    Raises:
        CheckError: it describes none; what is wrong is told with its place in the text.
        MessageTypeError: there is no such type.
    """
    definitions.message_class(message_type)
    findings = Findings()
    given = document.parse(text, "message", findings)
    findings.raise_errors()
    assert given is not None
    reader = _Reader(definitions, findings)
    try:
        reader.draft.message = reader.read(given.root, named(message_type), message_type)
    except _RefusedError:
        findings.raise_errors()
    return reader.draft


def full_type(name: str) -> str:
    """`geometry_msgs/msg/Twist` for `geometry_msgs/Twist`."""
    return re.sub(r"\A([^/]+)/([^/]+)\Z", r"\1/msg/\2", name)


class _Reader:
    """Values of YAML as rosbags has them in messages."""

    def __init__(self, definitions: Definitions, findings: Findings) -> None:
        self.draft = Draft(None)
        self._definitions = definitions
        self._findings = findings

    def read(self, given: Value, kind: Description, place: str) -> Any:
        """What stands for a field; `place` is how people are told of it."""
        if kind[0] == Nodetype.NAME:
            return self._message(given, kind[1])
        value = (self._scalar if kind[0] == Nodetype.BASE else self._array)(given, kind, place)
        if fault := find_fault(value, kind, place, self._definitions.fields):
            raise self._refused("G109", fault, given)
        return value

    def _message(self, given: Value, message_type: str) -> Any:
        message = self._definitions.initial(message_type)
        if (message_type, given.data) in ((HEADER, "auto"), (TIME, "now")):
            self.draft.stamps.append(message.stamp if message_type == HEADER else message)
            return message
        if not isinstance(given.data, dict):
            also = {HEADER: ", or 'auto'", TIME: ", or 'now'"}.get(message_type, "")
            what = f"{message_type} is a mapping of fields to values{also}; got {shown(given.data)}"
            raise self._refused("G108", what, given)
        names = [name for name, _ in self._definitions.definition(message_type).fields]
        known = dict(zip(names, self._definitions.fields(message_type), strict=True))
        for name, value in given.data.items():
            if name not in known:
                hint = did_you_mean(name, known) or listing(known, "fields")
                self._findings.add("G106", f"{message_type} has no field {name!r}", given.keys[name], hint)
                raise _RefusedError
            attribute, kind = known[name]
            setattr(message, attribute, self.read(value, kind, name))
        return message

    def _array(self, given: Value, kind: Description, place: str) -> Any:
        if not isinstance(given.data, list):
            raise self._refused("G108", f"{place} is a list; got {shown(given.data)}", given)
        element = kind[1][0]
        values = [self.read(value, element, f"{place}[{index}]") for index, value in enumerate(given.data)]
        if element[0] == Nodetype.BASE and element[1][0] not in TEXTS:
            return np.array(values, dtype_of(element[1][0]))
        return values

    def _scalar(self, given: Value, kind: Description, place: str) -> Any:
        data, name = given.data, kind[1][0]
        if name in TEXTS and isinstance(data, bool | int | float):
            return _as_written(given)
        if name == "bool":
            data = True if data in _YES or data == 1 else False if data in _NO or data == 0 else data
        elif name in ("float32", "float64"):
            data = _number(data)
        elif isinstance(data, float) and data.is_integer():
            data = int(data)
        elif name == "byte" and isinstance(data, int) and 127 < data < 256:
            data = signed_byte(data)
        wanted = {**dict.fromkeys(TEXTS, str), "bool": bool, "float32": float, "float64": float}.get(name, int)
        if not isinstance(data, wanted) or (isinstance(data, bool) and wanted is not bool):
            raise self._refused("G108", f"{place} is of type {name}; got {shown(given.data)}", given)
        return data

    def _refused(self, code: str, message: str, given: Value) -> _RefusedError:
        self._findings.add(code, message, given.span)
        return _RefusedError()


def _as_written(given: Value) -> str:
    """A plain scalar that YAML takes for something else than a text."""
    span = given.span
    return span.source.lines[span.line - 1][span.column - 1 : span.column - 1 + span.length]


def _number(data: Any) -> Any:
    """A floating-point number, also where YAML takes it for a text, as it does with `nan`."""
    try:
        return data if isinstance(data, bool) else float(data)
    except (TypeError, ValueError, OverflowError):
        return data
