"""Changes single values in the text of a YAML file without a change of any other text, such as comments."""

from __future__ import annotations

import re
from typing import Any

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Location, Value
from graphengine.format.yaml_text import comment as comment_line
from graphengine.format.yaml_text import flow

_END = "\r\n|[\n\r\x85\u2028\u2029]"
"""Pattern of a line end, the same as in `document`."""


class PatchError(ValueError):
    """A value in a YAML text cannot be set: the text has errors, or the change would affect other values too."""


def set_value(text: str, location: Location, value: Any, comment: str = "") -> str:
    """Return the text of a YAML file with one value set; missing mappings on the way to the value are added.

    The function parses the result, and checks that only this value differs from the original.

    Args:
        text: text of a YAML file that `document` can parse.
        location: keys and indices that lead to the value, such as `("nodes", "Drive", "inputs", "wheelRadius")`.
        value: plain data to set: a scalar if a scalar is replaced, any data if the key is new.
        comment: text of a comment line above the value; it replaces a comment line there that begins with the same two words.

    Raises:
        PatchError: the text has errors, the old value is not a scalar on one line, an alias repeats the old value, or the new
            key would not be in a mapping.
    """
    found = _read(text)
    expected = _with_value(found.data, location, value)
    old = found.find(*location)
    if old is not None:
        if not isinstance(value, str | int | float | bool) or isinstance(old.data, dict | list):
            raise PatchError(f"{_name(location)} is not a single value")
        lines = _split(text)
        line = old.span.line - 1
        start = old.span.column - 1
        lines[line] = lines[line][:start] + flow(value) + lines[line][start + old.span.length :]
    else:
        lines, line = _with_new_key(text, found, location, value)
    if comment:
        _put_comment(lines, line, comment_line(comment))
    result = "".join(lines)
    findings = Findings()
    read = document.parse(result, "", findings)
    if read is None or findings.errors or read.data != expected:
        raise PatchError(f"{_name(location)} cannot be changed without changing other values")
    return result


def _read(text: str) -> document.Document:
    findings = Findings()
    found = document.parse(text, "", findings)
    if found is None or findings.errors:
        raise PatchError("the YAML text has errors")
    return found


def _split(text: str) -> list[str]:
    """Return the lines of a text with their line ends, which are those of `document`."""
    parts = re.split(f"({_END})", text)
    return [line + end for line, end in zip(parts[::2], [*parts[1::2], ""], strict=True)]


def _line_end(lines: list[str]) -> str:
    """Return the line end of the first line that ends with CR, LF or both; LF if there is none."""
    return next((line[len(line.rstrip("\r\n")) :] for line in lines if line.endswith(("\n", "\r"))), "\n")


def _name(location: Location) -> str:
    return ".".join(map(str, location))


def _with_value(data: Any, location: Location, value: Any) -> Any:
    """Return a copy of plain data with the value at a location set; missing mappings on the way to the location are added."""
    if not location:
        return value
    key, *rest = location
    if isinstance(data, list) and isinstance(key, int) and 0 <= key < len(data):
        return [_with_value(one, tuple(rest), value) if i == key else one for i, one in enumerate(data)]
    if isinstance(data, dict) and isinstance(key, str):
        return data | {key: _with_value(data.get(key, {}), tuple(rest), value)}
    legal = f"{key!r} must be a key in a mapping or the index of an existing list element"
    raise PatchError(f"{_name(location)} cannot be set: {legal}")


def _with_new_key(text: str, found: document.Document, location: Location, value: Any) -> tuple[list[str], int]:
    """Return the lines of the text with a new key and value, and the index of the new key's line."""
    depth = next(end for end in range(len(location) - 1, -1, -1) if found.find(*location[:end]) is not None)
    for key in reversed(location[depth + 1 :]):
        value = {key: value}
    parent = found.find(*location[:depth])
    assert parent is not None
    lines, entry = _split(text), f"{flow(str(location[depth]))}: {flow(value)}"
    line, column = parent.span.line - 1, parent.span.column - 1
    if lines[line][column : column + 1] != "{":
        return _with_new_line(lines, parent, entry)
    end, more = _flow_end(lines[line], parent), ", " if parent.data else ""
    cut = column + 1 if end is None else end - 1
    head, tail = lines[line][:cut], lines[line][cut:]
    # In a mapping that spans lines, the entry goes to the beginning.
    lines[line] = f"{head}{entry}{more}{tail}" if end is None else head.rstrip(" ,") + f"{more}{entry}{tail}"
    return lines, line


def _flow_end(text: str, value: Value) -> int | None:
    """Return the index behind a flow-style value in a line; None if the value spans lines or has an alias."""
    begin = value.span.column - 1
    if not isinstance(value.data, dict | list):
        return begin + value.span.length
    inner = list(value.data.values()) if isinstance(value.data, dict) else value.data
    end: int | None = begin + 1
    if inner:
        end = _flow_end(text, inner[-1]) if inner[-1].span.line == value.span.line else None
    closed = re.compile(r"[ ,]*[]}]").match(text, end) if end is not None else None
    return closed.end() if closed else None


def _with_new_line(lines: list[str], parent: Value, entry: str) -> tuple[list[str], int]:
    """Insert a line with an entry after the last entry of a block mapping; return the lines and the index of the new line."""
    last = max(parent.keys.values(), key=lambda span: span.line)
    indent = " " * (last.column - 1)
    behind = last.line
    for row, line in enumerate(lines[behind:], behind + 1):
        text = line.strip()
        if text and not text.startswith("#"):
            inner = line.startswith((f"{indent} ", f"{indent}- "))
            if not inner and text != "-":
                break
            behind = row
    end = _line_end(lines)
    if not lines[behind - 1].endswith(("\n", "\r")):
        lines[behind - 1] += end
    lines.insert(behind, f"{indent}{entry}{end}")
    return lines, behind


def _put_comment(lines: list[str], line: int, text: str) -> None:
    """Insert a comment line above a line, or replace the comment line there if it begins with the same two words."""
    indent = lines[line][: len(lines[line]) - len(lines[line].lstrip(" "))]
    words = text.split()[:3]
    end = _line_end(lines)
    if line and lines[line - 1].split()[:3] == words:
        lines[line - 1] = f"{indent}{text}{end}"
    else:
        lines.insert(line, f"{indent}{text}{end}")
