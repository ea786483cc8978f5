"""Converts parameters of a session to and from messages of rcl_interfaces."""

from __future__ import annotations

from typing import Any

from graphengine.format import bounded_json
from graphengine.format.errors import UsageError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.parameters import ParameterType, python_value
from graphengine.runtime.parameter_table import Parameter

_ARRAYS = (ParameterType.BOOL_ARRAY, ParameterType.INTEGER_ARRAY, ParameterType.DOUBLE_ARRAY)


def given_value(message: Any, kind: ParameterType) -> Any:
    """Return the value in a ParameterValue message, for a parameter of the given type.

    For a parameter of type double or array, a string such as `1e-5` or `[1, 2.5]` becomes a number or list, because `ros2 param`
    sends such values as strings.

    Raises:
        UsageError: the message has no value: it asks for the deletion of the parameter.
    """
    value = python_value(message)
    if value is None:
        raise UsageError("parameters cannot be deleted")
    if isinstance(value, str) and kind in (ParameterType.DOUBLE, *_ARRAYS):
        return _spelled(value)
    return value


def _spelled(text: str) -> Any:
    """Return the number or the JSON list in a string; a string with neither is returned unchanged."""
    try:
        return float(text) if not text.lstrip().startswith("[") else bounded_json.parse(text)
    except ValueError:
        return text


def descriptor(name: str, parameter: Parameter | None) -> Any:
    """Return the ParameterDescriptor of a parameter; for None, an unknown parameter, a descriptor of type `NOT_SET`."""
    described = DEFINITIONS.initial("rcl_interfaces/msg/ParameterDescriptor")
    described.name = name
    if parameter is None:
        return described
    kind = parameter.type
    described.type = int(kind)
    described.description = " ".join(filter(None, (parameter.doc, f"[{parameter.unit}]" if parameter.unit else "")))
    described.additional_constraints = parameter.constraint
    described.read_only = parameter.command is None
    if parameter.limits is not None:
        which = "IntegerRange" if kind is ParameterType.INTEGER else "FloatingPointRange"
        limits = DEFINITIONS.initial(f"rcl_interfaces/msg/{which}")
        limits.from_value, limits.to_value = parameter.limits
        ranges = described.integer_range if kind is ParameterType.INTEGER else described.floating_point_range
        ranges.append(limits)
    return described
