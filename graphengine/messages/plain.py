"""Messages as plain data, and back: mappings by ROS's field names, lists, texts, numbers and booleans."""

from __future__ import annotations

from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname

from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages.definitions import DEFINITIONS, Definitions, dtype_of
from graphengine.messages.faults import find_fault
from graphengine.messages.interfaces import TEXTS, Description, signed_byte
from graphengine.messages.messages import MessageError, message_type


def to_plain(message: Any, definitions: Definitions = DEFINITIONS) -> dict[str, Any]:
    """What a message holds, in the order of its definition."""
    fields = definitions.definition(message_type(message)).fields
    return {name: _plain(getattr(message, normalize_fieldname(name)), kind, definitions) for name, kind in fields}


def from_plain(data: Any, message_type: str, definitions: Definitions = DEFINITIONS, place: str = "") -> Any:
    """A message of plain data; fields that are not there have ROS's initial values.

    Args:
        data: a mapping by field names.
        message_type: ROS name.
        definitions: where it is known.
        place: what the mapping is called, for errors.

    Raises:
        MessageError: something in it is not what the definition says.
        MessageTypeError: there is no such type.
    """
    if not isinstance(data, dict):
        raise MessageError(
            f"{place or message_type}: expected a mapping of the fields of {message_type}, got {shown(data)}"
        )
    kinds = dict(definitions.definition(message_type).fields)
    made = definitions.initial(message_type)
    for name, value in data.items():
        if name not in kinds:
            hint = (isinstance(name, str) and did_you_mean(name, kinds)) or listing(kinds, "fields")
            raise MessageError(f"{place or message_type}: {message_type} has no field {name!r}; {hint}")
        setattr(
            made,
            normalize_fieldname(name),
            _made(value, kinds[name], f"{place}.{name}" if place else name, definitions),
        )
    return made


def _plain(value: Any, description: Description, definitions: Definitions) -> Any:
    kind, detail = description
    if kind == Nodetype.NAME:
        return to_plain(value, definitions)
    if kind == Nodetype.BASE:
        return value & 0xFF if detail[0] == "byte" else value
    element, _ = detail
    if isinstance(value, np.ndarray):
        return (value.view(np.uint8) if element[1][0] == "byte" else value).tolist()
    return [_plain(item, element, definitions) for item in value]


def _made(value: Any, description: Description, place: str, definitions: Definitions) -> Any:
    kind, detail = description
    if kind == Nodetype.NAME:
        return from_plain(value, detail, definitions, place)
    if kind == Nodetype.BASE:
        made = _scalar(value, detail[0], place)
    else:
        if not isinstance(value, list | tuple):
            raise MessageError(f"{place}: expected a list, got {shown(value)}")
        element, _ = detail
        made = [_made(item, element, f"{place}[{i}]", definitions) for i, item in enumerate(value)]
        if element[0] == Nodetype.BASE and element[1][0] not in TEXTS:
            made = np.array(made, dtype_of(element[1][0]))
    fault = find_fault(made, description, place, definitions.fields)
    if fault:
        raise MessageError(fault)
    return made


def _scalar(value: Any, name: str, place: str) -> Any:
    """A value of the Python type that encoders take for a kind of number or text."""
    if name in TEXTS:
        legal, what = isinstance(value, str), "text"
    elif name == "bool":
        legal, what = isinstance(value, bool), "true or false"
    elif name.startswith("float"):
        legal, what = isinstance(value, int | float) and not isinstance(value, bool), "a number"
    else:
        legal, what = isinstance(value, int) and not isinstance(value, bool), "a whole number"
    if not legal:
        raise MessageError(f"{place}: expected {what}, got {shown(value)}")
    try:
        if name == "byte":
            return signed_byte(value)
        return float(value) if name.startswith("float") else value
    except ValueError:
        raise MessageError(f"{place} is {value!r}, not a byte") from None
    except OverflowError:
        raise MessageError(f"{place} is too large for a {name}") from None
