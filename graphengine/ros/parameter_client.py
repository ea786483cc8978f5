"""A client for the parameter services of one ROS 2 node."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.parameters import SERVICES
from graphengine.ros.service_caller import ServiceCaller
from graphengine.ros.transport import Transport

PATIENCE = 5.0
"""Maximum wait for the discovery of a service of the node, and maximum wait for its response, s."""


class ParameterClient:
    """Calls the parameter services of a node.

        client = ParameterClient(transport, "/dd100_0000/dd100")
        client.get(["cmd_vel.DiffController.maxLinearSpeed"])

    Args:
        transport: open transport; closing it also closes this client.
        node: full name of the node.
        definitions: message types.
    """

    def __init__(self, transport: Transport, node: str, definitions: Definitions = DEFINITIONS) -> None:
        self.node = node
        self._transport = transport
        self._definitions = definitions
        self._callers: dict[str, ServiceCaller] = {}

    def list(self, prefixes: Sequence[str] = ()) -> list[str]:
        """Return the sorted names of all parameters, or only of the parameters below the given prefixes.

        Raises:
            TransportError: the node does not answer in time; all other methods raise this error too.
        """
        return sorted(self._call("list_parameters", prefixes=list(prefixes)).result.names)

    def get(self, names: Sequence[str]) -> Sequence[Any]:
        """Return one ParameterValue for each name.

        If one of the parameters has no value, an rclcpp node returns an empty list.
        """
        return list(self._call("get_parameters", names=list(names)).values)

    def describe(self, names: Sequence[str]) -> Sequence[Any]:
        """Return a ParameterDescriptor for each name."""
        return list(self._call("describe_parameters", names=list(names)).descriptors)

    def set(self, parameters: Sequence[Any]) -> Sequence[Any]:
        """Set parameters, given as Parameter messages; return a SetParametersResult for each.

        Raises:
            TransportError: the node does not answer in time, or does not return one result for each parameter.
        """
        results = list(self._call("set_parameters", parameters=list(parameters)).results)
        if len(results) != len(parameters):
            reasons = "; ".join(dict.fromkeys(result.reason for result in results if result.reason))
            answered = f"{self.node} returned {len(results)} results for {len(parameters)} parameters"
            raise TransportError(f"{answered}: {reasons}" if reasons else answered)
        return results

    def _call(self, service: str, **fields: Any) -> Any:
        name, kind = f"{self.node}/{service}", SERVICES[service]
        if name not in self._callers:
            self._callers[name] = ServiceCaller(self._transport, name, kind, self._definitions)
        caller = self._callers[name]
        if not caller.becomes_ready(PATIENCE):
            raise TransportError(self._transport.foreign_services.get(name, "") or f"no node offers {name}")
        request = self._definitions.initial(f"{kind}_Request")
        for field, value in fields.items():
            setattr(request, field, value)
        try:
            return caller.call(request).result(PATIENCE)
        except TimeoutError:
            raise TransportError(f"{name}: no response within {PATIENCE:g} s") from None
