"""Converts a message to the rows of a tree; long arrays are shortened to their range and first elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.message_text import TypedValue
from graphengine.view.live_graphs import rounded

MOST_ROWS, MOST_ELEMENTS, LONGEST_TEXT = 500, 8, 200
"""Maximum number of rows to show of a message, elements of an array, and characters of a string."""
_STAMPS = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")

Row = Mapping[str, Any]


def message_rows(data: bytes, message_type: str, definitions: Definitions) -> list[Row]:
    """Return a row for each field: depth, path, name, type, text, and whether it can be plotted.

    If decoding fails, return one row with the error.
    """
    try:
        part = TypedValue.of(messages.decode(data, message_type, definitions), definitions)
    except GraphError as error:
        return [_row(0, "", "", "", str(error))]
    rows: list[Row] = []
    for row in _rows(part, "", 0):
        if len(rows) == MOST_ROWS:
            rows.append(_row(0, "…", "…", "", f"more than {MOST_ROWS} fields"))
            break
        rows.append(row)
    return rows


def _rows(part: TypedValue, path: str, depth: int) -> Iterator[Row]:
    for name, value in part.fields():
        yield from _field(name, value, f"{path}.{name}" if path else name, depth)


def _field(name: str, part: TypedValue, path: str, depth: int) -> Iterator[Row]:
    if part.is_message:
        if part.kind[1] in _STAMPS:
            yield _row(depth, path, name, part.kind[1], f"{part.value.sec + part.value.nanosec * 1e-9:.9f} s")
            return
        yield _row(depth, path, name, part.kind[1], "")
        yield from _rows(part, path, depth + 1)
    elif part.is_array and not part.scalar:
        count = len(part.value)
        yield _row(depth, path, name, f"{part.kind[1][0][1]}[{count}]", "" if count else "empty")
        for index, element in enumerate(part.value[:MOST_ELEMENTS]):
            inner = TypedValue(element, part.kind[1][0], part.definitions)
            yield from _field(f"[{index}]", inner, f"{path}[{index}]", depth + 1)
        if count > MOST_ELEMENTS:
            yield _row(depth + 1, f"{path}[…]", "…", "", f"{count - MOST_ELEMENTS} more")
    elif part.is_array:
        yield _row(depth, path, name, f"{part.scalar}[{len(part.value)}]", _array(part.value), plots=_numeric(part))
    else:
        yield _row(depth, path, name, part.scalar, _scalar(part.value), plots=_numeric(part))


def _row(depth: int, path: str, name: str, kind: str, text: str, *, plots: bool = False) -> Row:
    return {"depth": depth, "path": path, "name": name, "type": kind, "text": text, "plots": plots}


def _numeric(part: TypedValue) -> bool:
    """Return whether a field consists of numbers, which can be plotted."""
    return "string" not in part.scalar


def _array(values: Any) -> str:
    count = len(values)
    if not count:
        return "empty"
    first = ", ".join(_scalar(value) for value in values[:MOST_ELEMENTS])
    if count <= MOST_ELEMENTS:
        return first
    shown = f"{first}, …"
    if not isinstance(values, np.ndarray):
        return shown
    finite = values[np.isfinite(values)] if np.issubdtype(values.dtype, np.floating) else values
    return f"{finite.min():.5g} to {finite.max():.5g}: {shown}" if finite.size else shown


def _scalar(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, float | np.floating):
        return rounded(float(value), 6)
    text = str(value)
    return text if len(text) <= LONGEST_TEXT else f"{text[:LONGEST_TEXT]}…"
