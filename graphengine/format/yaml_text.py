"""Writes plain data as YAML text that `document` reads back as equal data."""

from __future__ import annotations

import math
import re
from typing import Any

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.-]*\Z")
_SPECIAL = frozenset(("true", "false", "null", "nan", "inf"))
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


class Reference(str):
    """A string with a reference to a parameter, such as `$(robot)/base_link`."""

    __slots__ = ()


def flow(value: Any) -> str:
    """Return a value as flow-style YAML on one line.

    Except in a `Reference`, `$` in strings is doubled, so that `$(name)` is read as plain text.
    """
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    return scalar(read_back(value))


def read_back(value: Any) -> Any:
    """Return the value that a reader gets from a value's text: except in a `Reference`, `$` in strings is doubled."""
    if isinstance(value, dict):
        return {key: read_back(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [read_back(item) for item in value]
    if isinstance(value, str):
        return str(value) if isinstance(value, Reference) else value.replace("$", "$$")
    return value


def block(value: Any) -> list[str]:
    """Return the lines of a YAML block scalar for a string of several lines; the first line is `|` or `|-`.

    The list is empty for all other values, and for a string that only a quoted scalar can represent.
    """
    if not isinstance(value, str) or "\n" not in value or value.endswith("\n\n"):
        return []
    lines = value.replace("$", "$$").removesuffix("\n").split("\n")
    plain = all(line.replace("\t", "").isprintable() and (not line or line.strip()) for line in lines)
    if not plain or not lines[0] or lines[0][0] in " \t":
        return []
    return ["|" if value.endswith("\n") else "|-", *lines]


def scalar(value: Any) -> str:
    """Return None, a number, boolean or string as a YAML scalar; a string is quoted if its characters require quotes."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, int | float):
        text = repr(value)
        return text if "." in text else text.replace("e", ".0e")  # YAML 1.1 reads 1e-07 as a string
    text = str(value)
    return text if _PLAIN.match(text) and text.lower() not in _SPECIAL else f'"{"".join(map(_escaped, text))}"'


def comment(text: str) -> str:
    """Return a text as a YAML comment on one line; a space replaces each unprintable character."""
    return "# " + "".join(c if c.isprintable() else " " for c in text)


def _escaped(character: str) -> str:
    if character in _ESCAPES:
        return _ESCAPES[character]
    if character.isprintable():
        return character
    number = ord(character)
    return f"\\x{number:02x}" if number < 256 else f"\\u{number:04x}" if number < 65536 else f"\\U{number:08x}"
