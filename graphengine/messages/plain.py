"""Builds messages from plain data: mappings with ROS field names as keys, lists, strings, numbers and booleans."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from rosbags.interfaces import Nodetype

from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages.definitions import DEFINITIONS, Definitions, dtype_of
from graphengine.messages.interfaces import TEXTS, Description, signed_byte
from graphengine.messages.message_validation import find_fault
from graphengine.messages.messages import MessageError

_PYTHON_TYPES: Mapping[str, type] = {**dict.fromkeys(TEXTS, str), "bool": bool, "float32": float, "float64": float}
"""Python type of the values of a ROS scalar type; the ROS types that are not listed are integers."""


def from_plain(data: Any, message_type: str, definitions: Definitions = DEFINITIONS, place: str = "") -> Any:
    """Return a message built from plain data; missing fields get their default values.

    Args:
        data: mapping from field names to values.
        message_type: ROS name of the type.
        definitions: definitions of all known message types.
        place: name of the mapping in error messages.

    Raises:
        MessageError: the data does not fit the message type.
        MessageTypeError: the type is unknown.
    """
    return Maker(definitions).message(data, message_type, place)


class Maker:
    """Builds messages from plain data. Subclasses read data in other representations or convert scalars differently.

    Args:
        definitions: definitions of all known message types.
    """

    shorthands: ClassVar[Mapping[str, str]] = {}
    """A dict from message types to the word that can replace a whole message of the type."""

    def __init__(self, definitions: Definitions) -> None:
        self.definitions = definitions

    def message(self, given: Any, message_type: str, place: str) -> Any:
        """Return a message built from a mapping of fields to values; `place` is its name in error messages."""
        made, data = self.definitions.initial(message_type), self.data(given)
        if not isinstance(data, dict):
            also = f", or '{self.shorthands[message_type]}'" if message_type in self.shorthands else ""
            what = f"{message_type} must be a mapping of fields to values{also}; got {shown(data)}"
            raise self.refused("G108", what, given, place)
        names = (name for name, _ in self.definitions.definition(message_type).fields)
        known = dict(zip(names, self.definitions.fields(message_type), strict=True))
        for name, value in data.items():
            if name not in known:
                hint = (isinstance(name, str) and did_you_mean(name, known)) or listing(known, "fields")
                raise self.refused("G106", f"{message_type} has no field {name!r}", given, place, name, hint)
            attribute, kind = known[name]
            setattr(made, attribute, self.make(value, kind, self.place_of(name, place)))
        return made

    def make(self, given: Any, kind: Description, place: str) -> Any:
        """Return the value of a field (a scalar, an array or a message); `place` is its name in error messages."""
        if kind[0] == Nodetype.NAME:
            return self.message(given, kind[1], place)
        made = (self._scalar if kind[0] == Nodetype.BASE else self._array)(given, kind, place)
        if fault := find_fault(made, kind, place, self.definitions.fields):
            raise self.refused("G109", fault, given)
        return made

    def data(self, given: Any) -> Any:
        """Return the plain data in a given value; here the value itself."""
        return given

    def scalar(self, given: Any, name: str) -> Any:
        """Convert a number, boolean or string to the field type `name`; a value that does not fit may be returned unchanged."""
        is_number = isinstance(given, int | float) and not isinstance(given, bool)
        if name.startswith("float") and is_number:
            return float(given)
        return signed_byte(given) if name == "byte" and isinstance(given, int) and is_number else given

    def place_of(self, name: str, place: str) -> str:
        """Return the name of a field in error messages; `place` is the name of the message that has the field."""
        return f"{place}.{name}" if place else name

    def refused(self, code: str, what: str, given: Any, place: str = "", key: Any = None, hint: str = "") -> Exception:
        """Return the error to raise for a value that does not fit.

        Args:
            code: code of the error; here not used.
            what: description of the fault.
            given: the value.
            place: name of the value, if `what` does not contain it.
            key: name of an unknown field; None for other faults.
            hint: advice; may be empty.
        """
        return MessageError("; ".join(filter(None, (f"{place}: {what}" if place else what, hint))))

    def _array(self, given: Any, kind: Description, place: str) -> Any:
        data, element = self.data(given), kind[1][0]
        if not isinstance(data, list | tuple):
            raise self.refused("G108", f"{place} must be a list; got {shown(data)}", given)
        values = [self.make(value, element, f"{place}[{index}]") for index, value in enumerate(data)]
        is_number = element[0] == Nodetype.BASE and element[1][0] not in TEXTS
        return np.array(values, dtype_of(element[1][0])) if is_number else values

    def _scalar(self, given: Any, kind: Description, place: str) -> Any:
        name = kind[1][0]
        wanted = _PYTHON_TYPES.get(name, int)
        try:
            made = self.scalar(given, name)
        except (OverflowError, ValueError):
            made = None
        if not isinstance(made, wanted) or (isinstance(made, bool) and wanted is not bool):
            raise self.refused("G108", f"{place} must be of type {name}; got {shown(self.data(given))}", given)
        return made
