"""A node with services that list the prims of the stage, and read and write their attributes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from graphengine.format import bounded_json
from graphengine.format.errors import ContextError, GraphError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import ServiceServer
from graphengine.node import Bound, Context, ExecOut, Fire, In, Prims, String
from graphengine.nodes.ros2.publisher import NetworkNode
from graphengine.nodes.touched import ANY, WIRED

_PACKAGE = "isaac_ros2_messages/srv"
Ask = Callable[[Prims, Any], Sequence[Any]]


class ROS2ServicePrim(NetworkNode, type="isaacsim.ros2.bridge.ROS2ServicePrim", gated=True):
    """Offers services of isaac_ros2_messages that list prims and attributes, and read and write attributes.

    Values are JSON; as in USD, quaternions are [w, x, y, z] and angles are in degrees. Only attributes that the simulation
    supports are available; a write to an attribute that cannot change during a simulation is refused. In each tick, the node
    handles the services one after the other, and the requests of one service in order of arrival.
    """

    prims_service_name: String = In(
        default="get_prims", setup=True, doc="name of the GetPrims service, which lists a prim and its descendants"
    )
    get_attributes_service_name: String = In(
        default="get_prim_attributes",
        setup=True,
        doc="name of the GetPrimAttributes service, which lists a prim's attributes and their types",
    )
    get_attribute_service_name: String = In(
        default="get_prim_attribute", setup=True, doc="name of the GetPrimAttribute service, which reads an attribute"
    )
    set_attribute_service_name: String = In(
        default="set_prim_attribute", setup=True, doc="name of the SetPrimAttribute service, which sets an attribute"
    )
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth 10"
    )
    exec_out = ExecOut(doc="fires once in each tick in which the node responds to requests")

    served: tuple[tuple[ServiceServer, Callable[[Any], Any]], ...] = Bound()

    def setup(self, context: Context) -> None:
        """Create the four service servers."""
        prims = context.stage()
        asked = (
            ("GetPrims", self.prims_service_name, get_prims),
            ("GetPrimAttributes", self.get_attributes_service_name, get_attributes),
            ("GetPrimAttribute", self.get_attribute_service_name, get_attribute),
            ("SetPrimAttribute", self.set_attribute_service_name, set_attribute),
        )
        facts = {**self.endpoint(), "collects_namespace": True, "qos_profile": self.qos_profile}
        self.served = tuple(
            (context.service_server(f"{_PACKAGE}/{kind}", service, **facts), partial(respond, kind, ask, prims))
            for kind, service, ask in asked
        )

    def writes(self) -> Iterable[str]:
        """Return resource keys that stand for the attributes of all prims."""
        return WIRED, ANY

    def compute(self) -> Fire:
        """Respond to the requests that arrived in this tick."""
        fired: Fire = None
        for server, respond in self.served:
            for request_id, request in server.take():
                server.answer(request_id, respond(request))
                fired = self.exec_out
        return fired


def respond(kind: str, ask: Ask, prims: Prims, request: Any) -> Any:
    """Return the response to a request; if the request is refused, the response contains only the reason.

    Args:
        kind: name of the service type, such as GetPrims.
        ask: function that handles the request and returns the response fields that precede `success`.
        prims: prims of the stage.
        request: request message.
    """
    response = DEFINITIONS.initial(f"{_PACKAGE}/{kind}_Response")
    try:
        return type(response)(*ask(prims, request), True, "")
    except GraphError as error:
        response.message = "; ".join(line.strip() for line in str(error).splitlines())
        return response


def get_prims(prims: Prims, request: Any) -> Sequence[Any]:
    """Return the paths and the types of the requested prim and its descendants."""
    found = prims.below(request.path)
    return [path for path, _ in found], [kind for _, kind in found]


def get_attributes(prims: Prims, request: Any) -> Sequence[Any]:
    """Return the names, the display names (equal to the names) and the types of the requested prim's attributes."""
    found = prims.attributes(request.path)
    return list(found), list(found), list(found.values())


def get_attribute(prims: Prims, request: Any) -> Sequence[Any]:
    """Return the value, as JSON, and the type of the requested attribute."""
    kind, value = prims.read(request.path, request.attribute)
    return json.dumps(value), kind


def set_attribute(prims: Prims, request: Any) -> Sequence[Any]:
    """Set an attribute to the requested value and return no fields: the response has only `success` and `message`.

    Raises:
        ContextError: the value is not JSON.
    """
    try:
        value = bounded_json.parse(request.value)
    except ValueError as error:
        raise ContextError(f"the value is not JSON: {error}") from error
    prims.write(request.path, request.attribute, value)
    return ()
