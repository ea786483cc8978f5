"""Parses definition files of messages, services and actions.

The file of a service has a request and a response, separated by `---`; that of an action has a goal, a result and a feedback
part. This module also defines the messages that ROS 2 derives from these parts.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import TypesysError, get_types_from_idl
from rosbags.typesys.base import make_typesdict
from rosbags.typesys.msg import MSGParser

from graphengine.format.errors import ContextError
from graphengine.format.regular_files import open_regular
from graphengine.format.wording import did_you_mean

KINDS = {"msg": 1, "srv": 2, "action": 3}
"""A dict from the suffix of a definition file to the number of its parts."""
MAX_BYTES = 256 * 1024
"""Maximum size of a definition file, bytes; the largest one in ROS 2 Jazzy has 6 kB."""

SCALARS = {
    "bool": "?",
    "byte": "b",  # rosbags takes it for signed, ROS 2 does not
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "<h",
    "uint16": "<H",
    "int32": "<i",
    "uint32": "<I",
    "int64": "<q",
    "uint64": "<Q",
    "float32": "<f",
    "float64": "<d",
}
"""Format character of the module `struct` for each ROS number type; `byte` is signed, as rosbags represents it."""


def signed_byte(value: int) -> int:
    """Return a byte, from 0 to 255, as the signed number from -128 to 127 that the encoder expects.

    Raises:
        ValueError: the number is not from 0 to 255.
    """
    if not 0 <= value <= 0xFF:
        raise ValueError(f"{value} is not a byte (0 to 255)")
    return (value ^ 0x80) - 0x80


_SNAKE = re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)*\Z")
_CAMEL = re.compile(r"[A-Z][A-Za-z0-9]*\Z")
TEXTS = ("string", "wstring")
"""String types of ROS; `wstring` is a wide string of UTF-16 units."""

Description = tuple[Any, Any]
"""Type of a field as rosbags represents it: a `Nodetype` and its arguments.

The arguments are the name and the maximum length of a number or string type (0: no limit), the name of a message type, or the
element type and the length of an array.
"""
Field = tuple[str, Description]
"""Name and type of a field."""

WIDE: Description = (Nodetype.BASE, ("wstring", 0))


class MessageTypeError(ContextError):
    """A message, service or action type is unknown, or its definition is invalid."""

    code = "G308"


class Definition(NamedTuple):
    """Constants, fields and default values of a type; `str` returns its text in the format of a `.msg` file."""

    constants: list[tuple[str, str, Any]]
    fields: list[Field]
    initial: Mapping[str, Any] = MappingProxyType({})
    """A dict from field names to the default values that the definition sets."""
    is_message: bool = True
    """Whether the type is a message. The definition of a service or action is needed only for its type hash."""

    def __str__(self) -> str:
        constants = [f"{kind} {name}={value}\n" for name, kind, value in self.constants]
        return "".join([*constants, *(f"{written(kind)} {name}\n" for name, kind in self.fields)])


class TypeName(NamedTuple):
    """The parts of a type name; for `std_srvs/srv/Trigger_Request` these are std_srvs, srv, Trigger and `_Request`."""

    package: str
    kind: str
    name: str
    part: str

    @property
    def source(self) -> str:
        """Name of the type whose file defines this type: the name without `part`, such as `std_srvs/srv/Trigger`."""
        return f"{self.package}/{self.kind}/{self.name}"

    @staticmethod
    def parse(message_type: str) -> TypeName | None:
        """Return the parts of a type name; None if the name is not legal in ROS 2, for example because it contains `..`."""
        package, _, rest = message_type.partition("/")
        kind, _, last = rest.partition("/")
        name, underscore, part = last.partition("_")
        legal = _SNAKE.match(package) and kind in KINDS and _CAMEL.match(name) and (kind != "msg" or not underscore)
        return TypeName(package, kind, name, underscore + part) if legal else None


def read(path: Path, name: TypeName) -> dict[str, Definition]:
    """Return a dict from ROS names to the definitions of all types in a file, including the service or action itself.

    Args:
        path: the definition file.
        name: name of the type that the file defines.

    Raises:
        MessageTypeError: the file cannot be read, or its content is not a valid definition.
    """
    text = _text(path)
    if path.suffix == ".idl":
        return _read_idl(path, name, text)
    parts, expected = re.split(r"^---[ \t]*$", text, flags=re.MULTILINE), KINDS[name.kind]
    if len(parts) != expected:
        what = f"{path} has {len(parts)} parts, a .{name.kind} file has {expected}"
        raise MessageTypeError(what, name.name, "separate the parts by a line with three dashes")
    lines = itertools.accumulate((part.count("\n") for part in parts[:-1]), initial=0)
    parsed = [_parse(path, name.package, part, line) for part, line in zip(parts, lines, strict=True)]
    if name.kind == "msg":
        return {name.source: parsed[0]}
    return _service(name.source, *parsed) if name.kind == "srv" else _action(name.source, *parsed)


def _text(path: Path) -> str:
    try:
        with open_regular(path) as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            text = f"{path} is larger than {MAX_BYTES // 1024} kB, too large for a definition"
            raise MessageTypeError(text, path.stem)
        return data.decode("utf-8").replace("\r\n", "\n")
    except (OSError, UnicodeDecodeError) as error:
        raise MessageTypeError(f"{path} cannot be read: {error}", path.stem) from None


def _parse(path: Path, package: str, text: str, line: int) -> Definition:
    """Return the definition in one part of a file; `line` is the number of lines before this part."""
    # A type without a package name is a message of the same package, in services and actions too.
    try:
        (message,) = MSGParser(f"MSG: {package}/msg/This\n{text}").specification()
    except (TypesysError, RecursionError, ValueError) as error:
        number, written = _first_fault(text)
        place = f"{path}:{line + number}: {written.strip()[:80]!r}" if number else str(path)
        raise MessageTypeError(f"{place} is not a definition of a field or constant", path.stem) from error
    for parsed in message.fields:
        if not _SNAKE.match(parsed.name):
            legal = "legal: lower-case letters, digits and single underscores; begins with a letter, ends with no underscore"
            raise MessageTypeError(f"{path}: the field name {parsed.name!r} is not legal in ROS 2", path.stem, legal)
    (constants, fields), *_ = make_typesdict([message]).values()
    initial = {parsed.name: _unescaped(parsed.value) for parsed in message.fields if parsed.value is not None}
    return _sound(path, Definition(list(constants), list(fields), initial))


def _unescaped(value: Any) -> Any:
    """Return a default value; in a string, remove the backslashes before quotes, which rosbags keeps."""
    return value.replace('\\"', '"').replace("\\'", "'") if isinstance(value, str) else value


def _first_fault(text: str) -> tuple[int, str]:
    """Return the number (from 1) and the text of the first malformed line; 0 and an empty text if no line is malformed."""
    for number, line in enumerate(text.split("\n"), 1):
        try:
            MSGParser(f"MSG: a/msg/This\n{line}").specification()
        except (TypesysError, RecursionError, ValueError):
            return number, line
    return 0, ""


def _read_idl(path: Path, name: TypeName, text: str) -> dict[str, Definition]:
    if name.kind != "msg":
        raise MessageTypeError(f"{path}: only messages can be read from IDL", name.name, f"use a .{name.kind} file")
    try:
        found = get_types_from_idl(text)
    except Exception as error:  # a parser of a large language fails in many ways
        raise MessageTypeError(f"{path} cannot be read as IDL: {str(error)[-80:]}", name.name) from error
    return {
        message_type: _sound(path, Definition(list(constants), list(fields)))
        for message_type, (constants, fields) in found.items()
    }


def _sound(path: Path, definition: Definition) -> Definition:
    """Check that names are unique and types can be encoded; return the definition with correct wide string types."""
    fields = [(name, replace_element(kind, _with_wide)) for name, kind in definition.fields]
    definition = definition._replace(fields=fields)
    names = Counter([field for field, _ in definition.fields] + [constant for constant, _, _ in definition.constants])
    for member, count in names.items():
        if count > 1:
            raise MessageTypeError(f"{path} defines {member!r} twice", path.stem)
    for member, description in definition.fields:
        kind, detail = element_of(description)
        written_type = detail.rpartition("/")[2] if kind == Nodetype.NAME else detail[0]
        if written_type == "wchar" or (written_type == "wstring" and detail[1]):
            raise MessageTypeError(f"{path}: {member!r} is a {written(description)}, which is not supported", path.stem)
        if kind == Nodetype.NAME and TypeName.parse(detail) is None:
            hint = did_you_mean(written_type, SCALARS)
            raise MessageTypeError(f"{path}: {member!r} has the unknown type {written_type!r}", path.stem, hint)
    return definition


def _with_wide(element: Description) -> Description:
    """Return the type of a wide string for `wstring`, which rosbags parses as a message name; return other types unchanged."""
    kind, detail = element
    return WIDE if kind == Nodetype.NAME and detail.endswith("/msg/wstring") else element


def replace_element(description: Description, replace: Callable[[Description], Description]) -> Description:
    """Apply a function to a type, or to the element type if the type is an array, and return the resulting type."""
    kind, detail = description
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return kind, (replace_element(detail[0], replace), detail[1])
    return replace(description)


def element_of(description: Description) -> Description:
    """Return the element type of an array; any other type is returned unchanged."""
    kind, detail = description
    return detail[0] if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else description


def message_of(description: Description) -> str:
    """Return the ROS name of a message type; empty for numbers, strings and arrays."""
    kind, detail = description
    return str(detail) if kind == Nodetype.NAME else ""


def written(description: Description) -> str:
    """Return a type as it is written in definition files, such as `float64[9]`."""
    kind, detail = description
    if kind == Nodetype.NAME:
        return str(detail).replace("/msg/", "/")
    if kind == Nodetype.BASE:
        return f"{detail[0]}<={detail[1]}" if detail[1] else str(detail[0])
    bound = "<=" if kind == Nodetype.SEQUENCE and detail[1] else ""
    return f"{written(detail[0])}[{bound}{detail[1] or ''}]"


def named(message_type: str) -> Description:
    """Return the field type of a nested message with this ROS name."""
    return (Nodetype.NAME, message_type)


def _service(name: str, request: Definition, response: Definition) -> dict[str, Definition]:
    """Return the definitions of a service: its request, response and introspection event, and the service itself."""
    optional = {part: (Nodetype.SEQUENCE, (named(f"{name}_{part.title()}"), 1)) for part in ("request", "response")}
    event = [("info", named("service_msgs/msg/ServiceEventInfo")), *optional.items()]
    parts = [(f"{part}_message", named(f"{name}_{part.title()}")) for part in ("request", "response", "event")]
    return {
        f"{name}_Request": request,
        f"{name}_Response": response,
        f"{name}_Event": Definition([], event),
        name: Definition([], parts, is_message=False),
    }


def _action(name: str, goal: Definition, result: Definition, feedback: Definition) -> dict[str, Definition]:
    """Return the definitions of an action: its messages, its services, and the action itself.

    See design.ros2.org/articles/actions.html.
    """
    identity = ("goal_id", named("unique_identifier_msgs/msg/UUID"))
    stamp = ("stamp", named("builtin_interfaces/msg/Time"))
    accepted, status = ("accepted", (Nodetype.BASE, ("bool", 0))), ("status", (Nodetype.BASE, ("int8", 0)))
    send = Definition([], [identity, ("goal", named(f"{name}_Goal"))]), Definition([], [accepted, stamp])
    get = Definition([], [identity]), Definition([], [status, ("result", named(f"{name}_Result"))])
    parts = {
        "goal": "Goal",
        "result": "Result",
        "feedback": "Feedback",
        "send_goal_service": "SendGoal",
        "get_result_service": "GetResult",
        "feedback_message": "FeedbackMessage",
    }
    return {
        f"{name}_Goal": goal,
        f"{name}_Result": result,
        f"{name}_Feedback": feedback,
        **_service(f"{name}_SendGoal", *send),
        **_service(f"{name}_GetResult", *get),
        f"{name}_FeedbackMessage": Definition([], [identity, ("feedback", named(f"{name}_Feedback"))]),
        name: Definition([], [(part, named(f"{name}_{last}")) for part, last in parts.items()], is_message=False),
    }
