"""Parameters of a session as messages of rcl_interfaces: types, values and descriptors."""

from __future__ import annotations

import json
from typing import Any

from graphengine.format.errors import UsageError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.parameters import ParameterType, parameter_message, python_value
from graphengine.runtime.parameter_table import Parameter

_ARRAYS = (ParameterType.BOOL_ARRAY, ParameterType.INTEGER_ARRAY, ParameterType.DOUBLE_ARRAY)


def message(parameter: Parameter, value: Any) -> Any:
    """Return a Parameter message for a parameter with the given value."""
    return parameter_message(parameter.name, parameter.type, value)


def given_value(message: Any, kind: ParameterType) -> Any:
    """Return the value of a ParameterValue, converted for a parameter of the given type.

    Integers are accepted as numbers. A text is accepted as the number or list that it spells, because `ros2 param` sends
    `1e-5` and `[1, 2.5]` as texts.

    Raises:
        UsageError: the value is not set.
    """
    value = python_value(message)
    if value is None:
        raise UsageError("parameters cannot be deleted")
    if isinstance(value, str) and kind in (ParameterType.DOUBLE, *_ARRAYS):
        return _spelled(value)
    return value


def _spelled(text: str) -> Any:
    """Return the real number or the list that a text spells, or the text itself."""
    try:
        return float(text) if not text.lstrip().startswith("[") else json.loads(text)
    except (ValueError, RecursionError):
        return text


def descriptor(name: str, parameter: Parameter | None) -> Any:
    """Return a ParameterDescriptor; of type `NOT_SET` for an unknown parameter."""
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
