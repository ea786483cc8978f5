"""The parameter `real_time_factor` of a session's node, for `ros2 param`, because simulation_interfaces cannot set the speed."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any

import numpy as np

from graphengine.control.service_host import Handle, Offers
from graphengine.messages.definitions import DEFINITIONS
from graphengine.runtime.command_queue import Desk
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session_core import SessionCore

NAME = "real_time_factor"
DESCRIPTION = "seconds of simulation per second of wall time; 0 for as fast as possible"
FASTEST = 1e6

# Of rcl_interfaces/msg/ParameterType.
_NOT_SET, _INTEGER, _DOUBLE = 0, 2, 3


def offer_parameters(offers: Offers, node: str, desk: Desk) -> None:
    """Offer the parameter services of a session's node.

    Args:
        offers: services to which the parameter services are added.
        node: full name of the node.
        desk: command queue of the session.

    Raises:
        MessageTypeError: the transport does not know the services' types.
    """
    handles: Mapping[str, Handle] = {
        "DescribeParameters": _describe,
        "GetParameterTypes": _types,
        "GetParameters": lambda request, response: desk.ask(lambda session: _get(session, request, response)),
        "ListParameters": _list,
        "SetParameters": partial(_set, desk),
        "SetParametersAtomically": partial(_set_atomically, desk),
    }
    for name, handle in handles.items():
        service = re.sub("(?<!^)([A-Z])", r"_\1", name).lower()
        offers.add(f"{node}/{service}", f"rcl_interfaces/srv/{name}", handle)


def _set(desk: Desk, request: Any, response: Any) -> Future[Any] | None:
    """Set the valid parameters, in order."""
    response.results = [_result(_refusal(parameter)) for parameter in request.parameters]
    pairs = zip(request.parameters, response.results, strict=True)
    return _write(desk, [parameter for parameter, result in pairs if result.successful])


def _set_atomically(desk: Desk, request: Any, response: Any) -> Future[Any] | None:
    """Set all parameters, or none if one is invalid."""
    refusals = [refusal for parameter in request.parameters if (refusal := _refusal(parameter))]
    response.result = _result(refusals[0] if refusals else "")
    return _write(desk, [] if refusals else request.parameters)


def _write(desk: Desk, parameters: Sequence[Any]) -> Future[Any] | None:
    """Set the rate of the session; of several values, the last one counts."""
    return desk.submit("rate", {"factor": _factor(parameters[-1]) or "max"}) if parameters else None


def _describe(request: Any, response: Any) -> None:
    for name in request.names:
        descriptor = DEFINITIONS.initial("rcl_interfaces/msg/ParameterDescriptor")
        descriptor.name = name
        if name == NAME:
            descriptor.type, descriptor.description = _DOUBLE, DESCRIPTION
            descriptor.additional_constraints = f"0, or {SLOWEST:g} to {FASTEST:g}"
        response.descriptors.append(descriptor)


def _types(request: Any, response: Any) -> None:
    response.types = np.array([_DOUBLE if name == NAME else _NOT_SET for name in request.names], np.uint8)


def _list(request: Any, response: Any) -> None:
    response.result.names = [NAME] if not request.prefixes or NAME in request.prefixes else []


def _get(session: SessionCore, request: Any, response: Any) -> None:
    response.values = [_value(session.pace or 0.0 if name == NAME else None) for name in request.names]


def _value(factor: float | None) -> Any:
    value = DEFINITIONS.initial("rcl_interfaces/msg/ParameterValue")
    if factor is not None:
        value.type, value.double_value = _DOUBLE, factor
    return value


def _factor(parameter: Any) -> float:
    value = parameter.value
    return float(value.integer_value if value.type == _INTEGER else value.double_value)


def _refusal(parameter: Any) -> str:
    """Return the reason why a parameter value is invalid; empty if it is valid."""
    if parameter.name != NAME:
        return f"unknown parameter {parameter.name[:200]!r}; the only one is {NAME!r}"
    if parameter.value.type not in (_INTEGER, _DOUBLE):
        return f"{NAME} must be a number"
    factor = _factor(parameter)
    legal = factor == 0.0 or SLOWEST <= factor <= FASTEST
    return "" if legal else f"{NAME} cannot be {factor:g}; legal: 0, or {SLOWEST:g} to {FASTEST:g}"


def _result(refusal: str) -> Any:
    result = DEFINITIONS.initial("rcl_interfaces/msg/SetParametersResult")
    result.successful, result.reason = not refusal, refusal
    return result
