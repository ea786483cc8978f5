"""Changes, adds and removes single values in the text of a YAML file without a change of any other text, such as comments."""

from __future__ import annotations

import re
from typing import Any

from graphengine.format import document
from graphengine.format.diagnostics import Findings
from graphengine.format.document import Location, Value
from graphengine.format.yaml_text import comment as comment_line
from graphengine.format.yaml_text import flow, read_back

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
        value: plain data to set: a scalar for a scalar on several lines, otherwise any data.
        comment: text of a comment line above the value; it replaces a comment line there that begins with the same two words.

    Raises:
        PatchError: the text has errors, the old value spans several lines, an alias repeats the old value, or the new key would
            not be in a mapping.
    """
    found = _read(text)
    expected = _with_value(found.data, location, read_back(value))
    old = found.find(*location)
    if old is not None:
        lines = _split(text)
        line, start = old.span.line - 1, old.span.column - 1
        end = _value_end(lines[line], old)
        if end is None:
            raise PatchError(f"{_name(location)} is not a value on one line")
        lines[line] = lines[line][:start] + flow(value) + lines[line][end:]
    elif isinstance(location[-1], int):
        lines, line = _with_new_item(text, found, location, value)
    else:
        lines, line = _with_new_key(text, found, location, value)
    if comment:
        _put_comment(lines, line, comment_line(comment))
    return _checked("".join(lines), expected, location)


def remove_value(text: str, location: Location) -> str:
    """Return the text of a YAML file without one value: the key with its value, or the element of a list.

    Raises:
        PatchError: the text has errors or no such value, the value is the first key of a list element, or an alias repeats it.
    """
    found = _read(text)
    old, parent = found.find(*location), found.find(*location[:-1])
    if old is None or parent is None or not location:
        raise PatchError(f"there is no {_name(location)}")
    lines = _split(text)
    key = parent.keys[str(location[-1])] if isinstance(parent.data, dict) else old.span
    line, start = key.line - 1, key.column - 1
    if lines[parent.span.line - 1][parent.span.column - 1 : parent.span.column] in ("{", "["):
        end = _value_end(lines[old.span.line - 1], old)
        if end is None or old.span.line != key.line:
            raise PatchError(f"{_name(location)} is not on one line")
        head, tail = lines[line][:start], lines[line][end:]
        behind = re.match(r"\s*,\s*", tail)
        head, tail = (head, tail[behind.end() :]) if behind else (re.sub(r",\s*\Z", "", head), tail)
        lines[line] = head + tail
    else:
        column = start if isinstance(parent.data, dict) else lines[line].rindex("-", 0, start)
        last = _last_row(lines, line, column)
        emptied = len(parent.data) == 1
        if emptied and len(location) > 1:
            row = _key_line(found, location[:-1])
            ended = lines[row].rstrip("\r\n")
            empty = "{}" if isinstance(parent.data, dict) else "[]"
            body, _, remark = ended.partition(" #")
            lines[row] = f"{body.rstrip()} {empty}{'  #' + remark if remark else ''}{lines[row][len(ended) :]}"
        del lines[line : last + 1]
    return _checked("".join(lines), _without(found.data, location), location)


def location_at(text: str, line: int, column: int) -> Location | None:
    """Return the keys and indices that lead to the value at a position of a YAML text; None if no value begins there.

    Args:
        text: text of a YAML file.
        line: line of the first character, from 1.
        column: column of the first character, from 1.

    Raises:
        PatchError: the text has errors.
    """
    pending: list[tuple[Location, Value]] = [((), _read(text).root)]
    while pending:
        location, value = pending.pop()
        if (value.span.line, value.span.column) == (line, column) and not isinstance(value.data, dict):
            return location
        items = (
            value.data.items()
            if isinstance(value.data, dict)
            else enumerate(value.data)
            if isinstance(value.data, list)
            else ()
        )
        pending += [((*location, key), inner) for key, inner in items]
    return None


def _checked(text: str, expected: Any, location: Location) -> str:
    """Return a patched text after a check that it has the expected data.

    Raises:
        PatchError: it has other data.
    """
    findings = Findings()
    read = document.parse(text, "", findings)
    if read is None or findings.errors or read.data != expected:
        raise PatchError(f"{_name(location)} cannot be changed without changing other values")
    return text


def _without(data: Any, location: Location) -> Any:
    """Return a copy of plain data without the value at a location, which exists."""
    key, *rest = location
    if isinstance(data, list):
        return [_without(one, tuple(rest)) if i == key else one for i, one in enumerate(data) if rest or i != key]
    return {
        name: _without(one, tuple(rest)) if name == key else one for name, one in data.items() if rest or name != key
    }


def _key_line(found: document.Document, location: Location) -> int:
    """Return the index of the line of a key."""
    return found.key_span(*location).line - 1


def _last_row(lines: list[str], first: int, column: int) -> int:
    """Return the index of the last line of the block entry that begins in a line at a column; later comments do not count."""
    last = first
    for row in range(first + 1, len(lines)):
        text = lines[row]
        indent = len(text) - len(text.lstrip(" "))
        if not text.strip() or (text.lstrip().startswith("#") and indent <= column):
            continue
        listed = indent == column and text.lstrip().startswith("- ") and not lines[first][column:].startswith("- ")
        if indent <= column and not listed:
            break
        last = row
    return last


def _value_end(text: str, value: Value) -> int | None:
    """Return the index of the character after a value in its line; None if the value spans several lines or is in block style."""
    if not isinstance(value.data, dict | list):
        return value.span.column - 1 + value.span.length
    return _flow_end(text, value) if text[value.span.column - 1] in "{[" else None


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
    if isinstance(data, list) and key == len(data) and not rest:
        return [*data, value]
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


def _with_new_item(text: str, found: document.Document, location: Location, value: Any) -> tuple[list[str], int]:
    """Return the lines of the text with an item added at the end of a list, and the index of the new item's line."""
    parent = found.find(*location[:-1])
    assert parent is not None
    lines = _split(text)
    line, column = parent.span.line - 1, parent.span.column - 1
    if lines[line][column : column + 1] == "[":
        end = _flow_end(lines[line], parent)
        if end is None:
            raise PatchError(f"{_name(location[:-1])} is not on one line")
        head = lines[line][: end - 1].rstrip(" ,")
        lines[line] = f"{head}{', ' if parent.data else ''}{flow(value)}{lines[line][end - 1 :]}"
        return lines, line
    dash = lines[line].rindex("-", 0, parent.data[0].span.column - 1)
    last = _last_row(lines, parent.data[-1].span.line - 1, dash)
    ending = lines[last][len(lines[last].rstrip("\r\n")) :]
    if not ending:
        ending = "\n"
        lines[last] += ending
    lines.insert(last + 1, f"{' ' * dash}- {flow(value)}{ending}")
    return lines, last + 1


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
