"""Checks and encodes messages that users give, as message objects or as mappings of their fields."""

from __future__ import annotations

import struct
from typing import Any

from graphengine.messages import messages
from graphengine.messages.definitions import Definitions
from graphengine.messages.message_template import Encoder, Template
from graphengine.messages.plain import from_plain

_KINDS = {"?": (bool,), **dict.fromkeys("df", (float, int)), **dict.fromkeys("BhHiIqQ", (int,))}
"""A dict from a `struct` character to the Python types of its values; `b` of `byte` is missing: it needs a conversion."""


class CheckedEncoder:
    """Encodes the messages of one type. If only numbers differ, they are written into the bytes of an earlier message.

    Args:
        message_type: ROS name of the type.
        definitions: definitions of all known message types.
    """

    def __init__(self, message_type: str, definitions: Definitions) -> None:
        self._type, self._definitions = message_type, definitions
        self._encoder = Encoder(definitions, checked=True)
        self._initial, self._places = _numbers(message_type, definitions)

    def encode(self, message: Any) -> bytes:
        """Return a message object, or a mapping of its fields, as CDR bytes.

        Raises:
            MessageError: the message does not match the type.
        """
        if isinstance(message, dict):
            made = bytearray(self._initial)
            if made and _write(message, self._places, made):
                return bytes(made)
            message = from_plain(message, self._type, self._definitions)
        elif (given := messages.message_type(message)) != self._type:
            raise messages.MessageError(f"expected {self._type}, got {given}")
        return self._encoder.encode(message)


def _numbers(message_type: str, definitions: Definitions) -> tuple[bytes, dict[str, Any]]:
    """Return the bytes of an initial message, and nested dicts from field names to the places of the numbers in the bytes.

    If the type contains more than numbers, both results are empty.
    """
    message, places = definitions.initial(message_type), dict[str, Any]()
    template = Template.of(message, definitions)
    if template is None or not template.only_numbers:
        return b"", {}
    for offset, code, path in template.numbers:
        *parents, name = path.split(".")[1:]
        place = places
        for parent in parents:
            place = place.setdefault(parent, {})
        if code in _KINDS:
            place[name] = struct.Struct(f"<{code}").pack_into, offset, _KINDS[code]
    return messages.encode(message, definitions), places


def _write(data: dict[Any, Any], places: dict[str, Any], made: bytearray) -> bool:
    """Write the numbers of a mapping to bytes; return False if a value needs a conversion or does not match its field."""
    for name, value in data.items():
        place = places.get(name)
        if type(value) is dict and type(place) is dict:
            if not _write(value, place, made):
                return False
        elif type(place) is not tuple or type(value) not in place[2]:
            return False
        else:
            try:
                place[0](made, place[1], value)
            except (struct.error, OverflowError):
                return False
    return True
