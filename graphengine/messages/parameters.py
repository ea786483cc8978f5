"""Converts the values of ROS parameters between Python values and messages of rcl_interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from graphengine.messages.definitions import DEFINITIONS


class ParameterType(IntEnum):
    """Types of ROS parameters, with the numbers of rcl_interfaces/msg/ParameterType."""

    NOT_SET = 0
    BOOL = 1
    INTEGER = 2
    DOUBLE = 3
    STRING = 4
    BYTE_ARRAY = 5
    BOOL_ARRAY = 6
    INTEGER_ARRAY = 7
    DOUBLE_ARRAY = 8
    STRING_ARRAY = 9


ARRAY_OF = ParameterType.BOOL_ARRAY - ParameterType.BOOL
"""Difference between the number of an array type and that of its element type."""

Value = bool | int | float | str | list[bool] | list[int] | list[float] | list[str]

SERVICES = {
    "describe_parameters": "rcl_interfaces/srv/DescribeParameters",
    "get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
    "get_parameters": "rcl_interfaces/srv/GetParameters",
    "list_parameters": "rcl_interfaces/srv/ListParameters",
    "set_parameters": "rcl_interfaces/srv/SetParameters",
    "set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
}
"""A dict from the last part of a service name, as in `NODE/get_parameters`, to the type of this parameter service."""

EVENTS, EVENT = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"
"""The topic on which all nodes publish changes of their parameters, and the message type of the topic."""

_DTYPES = {ParameterType.BOOL_ARRAY: np.bool_, ParameterType.INTEGER_ARRAY: np.int64}
_DTYPES |= {ParameterType.DOUBLE_ARRAY: np.float64, ParameterType.BYTE_ARRAY: np.int8}


def value_message(kind: ParameterType, value: Any) -> Any:
    """Return a ParameterValue; its type is `NOT_SET` if an integer does not fit into a signed 64-bit number.

    Args:
        kind: type of the parameter.
        value: value of this type; an array can be any sequence.
    """
    message = DEFINITIONS.initial("rcl_interfaces/msg/ParameterValue")
    if kind is ParameterType.NOT_SET:
        return message
    try:
        given = np.array(value, _DTYPES[kind]) if kind in _DTYPES else value
        if kind is ParameterType.INTEGER:
            np.int64(value)
    except OverflowError:
        return message
    message.type = int(kind)
    setattr(message, _field(kind), list(given) if kind is ParameterType.STRING_ARRAY else given)
    return message


def parameter_message(name: str, kind: ParameterType, value: Any) -> Any:
    """Return an rcl_interfaces/Parameter with a name and a value of the given type."""
    message = DEFINITIONS.initial("rcl_interfaces/msg/Parameter")
    message.name, message.value = name, value_message(kind, value)
    return message


def python_value(message: Any) -> Value | None:
    """Return the value in a ParameterValue; None if the parameter is not set or has an unknown type."""
    kind = type_of(message)
    if kind is ParameterType.NOT_SET:
        return None
    value: Any = getattr(message, _field(kind))
    if kind is ParameterType.BYTE_ARRAY:
        value = np.asarray(value).astype(np.uint8)
    if isinstance(value, np.ndarray):
        return list(value.tolist())
    return list(value) if kind is ParameterType.STRING_ARRAY else value


def type_of(message: Any) -> ParameterType:
    """Return the type of a ParameterValue; an unknown type counts as `NOT_SET`."""
    known = message.type in ParameterType._value2member_map_
    return ParameterType(message.type) if known else ParameterType.NOT_SET


def fitting_type(value: object) -> ParameterType:
    """Return the parameter type for a Python value; `NOT_SET` if no parameter type fits the value."""
    scalars = {bool: ParameterType.BOOL, int: ParameterType.INTEGER}
    scalars |= {float: ParameterType.DOUBLE, str: ParameterType.STRING}
    if not isinstance(value, Sequence) or isinstance(value, str):
        return scalars.get(type(value), ParameterType.NOT_SET)
    kinds = {scalars.get(type(item), ParameterType.NOT_SET) for item in value} or {ParameterType.BOOL}
    if kinds == {ParameterType.INTEGER, ParameterType.DOUBLE}:
        kinds = {ParameterType.DOUBLE}
    kind = kinds.pop() if len(kinds) == 1 else ParameterType.NOT_SET
    return ParameterType(kind + ARRAY_OF) if kind is not ParameterType.NOT_SET else kind


def _field(kind: ParameterType) -> str:
    return f"{kind.name.lower()}_value"
