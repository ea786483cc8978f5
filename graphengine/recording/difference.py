"""Finds the differences between two messages of the same type, with the name of each field and both values."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import MessageTypeError


class FieldDifference(NamedTuple):
    """A field that differs, such as `pose.pose.position.x` or `ranges[12]`, with both values."""

    field: str
    recorded: str
    replayed: str

    def __str__(self) -> str:
        return f"{self.field}: recorded {self.recorded}, replayed {self.replayed}"


def differences(
    recorded: bytes, replayed: bytes, message_type: str, definitions: Definitions = DEFINITIONS
) -> list[FieldDifference]:
    """Return all fields that differ; an array of numbers has one entry, for the first element that differs.

    If the messages differ only in bytes that are not decoded, such as padding, the result is the first such byte. The bits of
    numbers are compared, so that NaN equals NaN and -0 differs from 0.
    """
    try:
        one, other = (messages.decode(data, message_type, definitions) for data in (recorded, replayed))
    except (messages.MessageError, MessageTypeError):
        return [_of_bytes(recorded, replayed)]
    return list(_differences(one, other, "")) or [_of_bytes(recorded, replayed)]


def _differences(one: Any, other: Any, place: str) -> Iterator[FieldDifference]:
    if dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            if field.name != "__msgtype__":
                where = f"{place}.{field.name}" if place else field.name
                yield from _differences(getattr(one, field.name), getattr(other, field.name), where)
    elif isinstance(one, np.ndarray):
        yield from _of_arrays(one, other, place)
    elif isinstance(one, list):
        if len(one) != len(other):
            yield FieldDifference(f"len({place})", str(len(one)), str(len(other)))
        for index, pair in enumerate(zip(one, other, strict=False)):
            yield from _differences(*pair, f"{place}[{index}]")
    elif not _same(one, other):
        yield FieldDifference(place, _shown(one), _shown(other))


def _of_arrays(one: Any, other: Any, place: str) -> Iterator[FieldDifference]:
    if len(one) != len(other):
        yield FieldDifference(f"len({place})", str(len(one)), str(len(other)))
        return
    bits = [array.view(np.uint8).reshape(len(array), array.itemsize) for array in (one, other)]
    unlike = np.flatnonzero((bits[0] != bits[1]).any(axis=1))
    if unlike.size:
        first = int(unlike[0])
        more = f" (and {unlike.size - 1} more of {len(one)} elements)" if unlike.size > 1 else ""
        yield FieldDifference(f"{place}[{first}]", _shown(one[first]), f"{_shown(other[first])}{more}")


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return struct.pack("<d", one) == struct.pack("<d", other)
    return bool(one == other)


def _shown(value: Any) -> str:
    text = repr(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= 80 else f"{text[:80]}…"


def _of_bytes(one: bytes, other: bytes) -> FieldDifference:
    """Return the first byte that differs, or the sizes of the messages if these differ."""
    if len(one) != len(other):
        return FieldDifference("size", f"{len(one)} bytes", f"{len(other)} bytes")
    at = next((index for index, (a, b) in enumerate(zip(one, other, strict=True)) if a != b), 0)
    return FieldDifference(f"byte {at} of {len(one)}", f"0x{one[at]:02x}", f"0x{other[at]:02x}")
