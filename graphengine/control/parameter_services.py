"""Creates the six parameter services of one ROS 2 node, such as `get_parameters`, and handles their requests."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from graphengine.control.parameter_messages import descriptor, given_value
from graphengine.control.service_host import Handle, ServiceHost
from graphengine.format.errors import GraphError, RecordingError, UsageError
from graphengine.format.wording import did_you_mean
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.parameters import SERVICES, ParameterType, value_message
from graphengine.ros.transport import Complain, Transport
from graphengine.runtime.command import Command
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.parameter_table import Parameter
from graphengine.runtime.session_core import SessionCore

MAX_REQUEST = 1000
"""Maximum number of parameters that one request sets; the session sets all of them between two ticks.

A request that reads parameters can name as many as the node has, even if these are more.
"""
_SUGGESTIONS = 3
"""Maximum number of errors in one response that suggest a similar name for an unknown parameter."""


class ParameterServices:
    """The parameter services of one node.

    The session's thread executes requests that set parameters; a thread of the transport answers all other requests.

    Args:
        node: full name of the node.
        table: parameters of the node by name; the attribute `table` may be replaced at any time.
        queue: command queue of the session.
        transport: transport on which the services are created.
        complain: called with one warning about malformed requests for each service.

    Raises:
        TransportError: the transport is closed.
    """

    def __init__(
        self, node: str, table: Mapping[str, Parameter], queue: CommandQueue, transport: Transport, complain: Complain
    ) -> None:
        self.table = table
        self._queue = queue
        self._offers = ServiceHost(transport, complain, node)
        handles: dict[str, Handle] = {
            "describe_parameters": self._reading("names", self._describe),
            "get_parameter_types": self._reading("names", self._types),
            "get_parameters": self._reading("names", self._get),
            "list_parameters": self._reading("prefixes", self._list),
            "set_parameters": self._set,
            "set_parameters_atomically": self._set_atomically,
        }
        try:
            for name, handle in handles.items():
                self._offers.add(f"{node}/{name}", SERVICES[name], handle, _finish)
        except BaseException:
            self._offers.close()
            raise

    def close(self) -> None:
        """Destroy the services. Safe to call twice."""
        self._offers.close()

    def _reading(self, field: str, answer: Callable[[Any, Any], None]) -> Handle:
        """Return a handler; the response stays empty if `field` has more names than `MAX_REQUEST` and than the node's table."""

        def handle(request: Any, response: Any) -> None:
            if len(getattr(request, field)) <= max(MAX_REQUEST, len(self.table)):
                answer(request, response)

        return handle

    def _describe(self, request: Any, response: Any) -> None:
        response.descriptors = [descriptor(name, self.table.get(name)) for name in request.names]

    def _types(self, request: Any, response: Any) -> None:
        found = [self.table.get(name) for name in request.names]
        kinds = [ParameterType.NOT_SET if each is None else each.type for each in found]
        response.types = np.array(kinds, np.uint8)

    def _get(self, request: Any, response: Any) -> None:
        found = [self.table.get(name) for name in request.names]
        unset = value_message(ParameterType.NOT_SET, None)
        response.values = [unset if each is None else each.message(each.read()).value for each in found]

    def _list(self, request: Any, response: Any) -> None:
        names = listed(self.table, request.prefixes, request.depth)
        response.result.names = names
        response.result.prefixes = sorted({name.rpartition(".")[0] for name in names if "." in name})

    def _set(self, request: Any, response: Any) -> Future[Any] | None:
        """Queue a command that sets the parameters one by one; an error with one parameter does not affect the others."""
        parameters = request.parameters
        if refusal := _too_many(parameters):
            response.results = [refusal]
            return None
        response.results = [_refused("") for _ in parameters]
        commands: list[tuple[Any, Command | None]] = []
        failures = 0
        for parameter, result in zip(parameters, response.results, strict=True):
            try:
                commands.append((result, self._command(parameter, suggest=failures < _SUGGESTIONS)))
            except GraphError as error:
                result.reason = reason(error)
                failures += 1

        def act(session: SessionCore) -> None:
            for result, command in commands:
                try:
                    if command is not None:
                        command.apply(session)
                except RecordingError:
                    raise
                except GraphError as error:
                    result.reason = reason(error)
                else:
                    result.successful = True

        return self._queue.ask(act)

    def _set_atomically(self, request: Any, response: Any) -> Future[Any] | None:
        """Queue a command that sets all parameters; if one parameter cannot be set, none changes."""
        parameters = request.parameters
        if refusal := _too_many(parameters):
            response.result = refusal
            return None
        try:
            commands = [(self._known(parameter.name), self._command(parameter)) for parameter in parameters]
        except GraphError as error:
            response.result.reason = reason(error)
            return None

        def act(session: SessionCore) -> None:
            undoing: list[Command] = []
            try:
                for parameter, command in commands:
                    if command is None or parameter.command is None:
                        continue
                    undo = parameter.undo()
                    command.apply(session)
                    undoing.insert(0, undo)
            except RecordingError:
                raise
            except GraphError:
                for undo in undoing:
                    undo.apply(session)
                raise
            response.result.successful = True

        return self._queue.ask(act)

    def _known(self, name: str, *, suggest: bool = True) -> Parameter:
        parameter = self.table.get(name)
        if parameter is None:
            near = did_you_mean(name[:200], self.table) if suggest else ""
            raise UsageError(f"unknown parameter {name[:200]!r}" + (f"; {near}" if near else ""))
        return parameter

    def _command(self, given: Any, *, suggest: bool = True) -> Command | None:
        """Return the command that sets a parameter; None if the parameter is read-only and already has the value.

        Args:
            given: Parameter message of the request.
            suggest: whether the error about an unknown parameter suggests a similar name.

        Raises:
            UsageError: the parameter is unknown or read-only, or the value is invalid.
        """
        parameter = self._known(given.name, suggest=suggest)
        value = given_value(given.value, parameter.type)
        if parameter.command is not None:
            return parameter.command(value)
        if not parameter.has(value):
            raise UsageError(f"{parameter.name} is read-only")
        return None


def listed(names: Mapping[str, object], prefixes: Sequence[str], depth: int) -> list[str]:
    """Return the sorted parameter names for a response of list_parameters, with the same selection as in rclcpp.

    Args:
        names: all parameter names.
        prefixes: a name is listed if it equals a prefix or begins with a prefix and a dot; empty lists all names.
        depth: maximum number of name parts below the prefix; 0 means no limit.
    """

    def matches(name: str) -> bool:
        if not prefixes:
            return not depth or name.count(".") < depth
        return any(
            name == prefix
            or (name.startswith(f"{prefix}.") and (not depth or name[len(prefix) + 1 :].count(".") < depth))
            for prefix in prefixes
        )

    return sorted(filter(matches, names))


def _too_many(parameters: Sequence[Any]) -> Any | None:
    """Return a SetParametersResult with an error if a request has too many parameters; otherwise None."""
    if len(parameters) <= MAX_REQUEST:
        return None
    return _refused(f"{len(parameters)} parameters in one request; legal: up to {MAX_REQUEST}")


def reason(error: BaseException) -> str:
    """Return the message of an error as a single line."""
    return "; ".join(line.strip() for line in str(error).splitlines() if line.strip())


def _refused(why: str) -> Any:
    result = DEFINITIONS.initial("rcl_interfaces/msg/SetParametersResult")
    result.successful, result.reason = False, why
    return result


def _finish(response: Any, error: BaseException | None) -> None:
    """Complete a response: with an error, each failed result without a reason gets the error's text."""
    if error is None:
        return
    results = response.results if hasattr(response, "results") else [response.result]
    for result in results:
        if not result.successful:
            result.reason = result.reason or reason(error)
