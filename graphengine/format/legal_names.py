"""Pydantic types for the names, prim paths and namespaces in files."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from graphengine.format.wording import shown


def _plain_path(path: str) -> str:
    if any(part in (".", "..") for part in path.split("/")):
        raise ValueError("a prim path cannot contain '.' or '..'")
    if any(letter.isspace() for letter in path):
        raise ValueError(f"a prim path cannot contain blanks, got {shown(path)}")
    return path


_PART = "[A-Za-z_][A-Za-z0-9_]*"


def _robot_path(path: str) -> str:
    if not re.fullmatch(f"(/{_PART})+", path):
        legal = "such as /World/robot, whose names consist of letters, digits and '_' and do not begin with a digit"
        raise ValueError(f"{path!r} is not a legal path for a robot's prim; write a path {legal}")
    return path


_NAMESPACE = re.compile(rf"\W*({_PART}(/{_PART})*)?\W*")  # \W does not match letters of other alphabets
NAMESPACE_FIELD = re.compile(r"\{(name|index)(?::0([1-9]))?\}")
"""Pattern of the placeholders `{name}`, `{index}` and `{index:04}` for a robot's name and number in a namespace."""


def _namespace(value: str) -> str:
    """Return a value that can be part of a ROS 2 namespace; slashes and punctuation at both ends are trimmed later.

    Raises:
        ValueError: the value has other illegal characters, an empty part, or a part that begins with a digit.
    """
    if not _NAMESPACE.fullmatch(value):
        legal = "legal: letters A-Z a-z, digits and _, in parts separated by /; no part is empty or starts with a digit"
        raise ValueError(f"{value!r} cannot be part of a ROS 2 namespace; {legal}")
    return value


def _namespace_pattern(value: str) -> str:
    if re.search(r"[{}]", NAMESPACE_FIELD.sub("", value)):
        raise ValueError(f"{value!r} has an unknown placeholder; legal placeholders: {{name}}, {{index}}, {{index:04}}")
    _namespace(NAMESPACE_FIELD.sub(lambda field: "name" if field[1] == "name" else "0", value))
    return value


Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=200)]
PrimPath = Annotated[str, AfterValidator(_plain_path)]
RobotPath = Annotated[str, Field(max_length=500), AfterValidator(_robot_path)]
Namespace = Annotated[str, AfterValidator(_namespace)]
NamespacePattern = Annotated[str, AfterValidator(_namespace_pattern)]
