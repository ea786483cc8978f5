"""Services that show the prims of the stage, and change some of their attributes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from graphengine.format.errors import ContextError, GraphError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import ServiceServer
from graphengine.node import Bound, Context, ExecOut, Fire, In, Prims, String
from graphengine.nodes.ros2.publisher import NetworkNode
from graphengine.nodes.touched import ANY, WIRED

_PACKAGE = "isaac_ros2_messages/srv"
Ask = Callable[[Prims, Any], Sequence[Any]]


class ROS2ServicePrim(NetworkNode, type="isaacsim.ros2.bridge.ROS2ServicePrim", gated=True):
    """Lists prims and their attributes, reads an attribute and writes one, for services of isaac_ros2_messages.

    Values are JSON, quaternions [w, x, y, z] and angles degrees, as USD has them. Attributes are the ones that stand for
    something here; those that cannot be changed while the simulation runs answer so. Requests of a tick are answered service
    by service, each in order.
    """

    prims_service_name: String = In(default="get_prims", setup=True, doc="GetPrims: a prim and all below it")
    get_attributes_service_name: String = In(
        default="get_prim_attributes", setup=True, doc="GetPrimAttributes: names and types"
    )
    get_attribute_service_name: String = In(default="get_prim_attribute", setup=True, doc="GetPrimAttribute")
    set_attribute_service_name: String = In(default="set_prim_attribute", setup=True, doc="SetPrimAttribute")
    qos_profile: String = In(default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, 10")
    exec_out = ExecOut(doc="fires when a request was answered")

    served: tuple[tuple[ServiceServer, Callable[[Any], Any]], ...] = Bound()

    def setup(self, context: Context) -> None:
        """Offer the services."""
        prims = context.stage()
        asked = (
            ("GetPrims", self.prims_service_name, get_prims),
            ("GetPrimAttributes", self.get_attributes_service_name, get_attributes),
            ("GetPrimAttribute", self.get_attribute_service_name, get_attribute),
            ("SetPrimAttribute", self.set_attribute_service_name, set_attribute),
        )
        self.served = tuple(
            (self.offer(context, kind, name), partial(respond, kind, ask, prims)) for kind, name, ask in asked
        )

    def offer(self, context: Context, name: str, service: str) -> ServiceServer:
        """One of the services."""
        facts = {**self.endpoint(), "collects_namespace": True, "qos_profile": self.qos_profile}
        return context.service_server(f"{_PACKAGE}/{name}", service, **facts)

    def writes(self) -> Iterable[str]:
        """Any attribute of any prim."""
        return WIRED, ANY

    def compute(self) -> Fire:
        """Answer what was asked."""
        fired: Fire = None
        for server, respond in self.served:
            for request_id, request in server.take():
                server.answer(request_id, respond(request))
                fired = self.exec_out
        return fired


def respond(kind: str, ask: Ask, prims: Prims, request: Any) -> Any:
    """The response to a request; an empty one that says why, where the request is refused.

    Args:
        kind: of the service.
        ask: returns the fields of the response before `success`.
        prims: of the stage.
        request: of the service.
    """
    response = DEFINITIONS.initial(f"{_PACKAGE}/{kind}_Response")
    try:
        return type(response)(*ask(prims, request), True, "")
    except GraphError as error:
        response.message = "; ".join(line.strip() for line in str(error).splitlines())
        return response


def get_prims(prims: Prims, request: Any) -> Sequence[Any]:
    """Paths and types of a prim and of all below it."""
    found = prims.below(request.path)
    return [path for path, _ in found], [kind for _, kind in found]


def get_attributes(prims: Prims, request: Any) -> Sequence[Any]:
    """Names and types of a prim's attributes; they are displayed by their names."""
    found = prims.attributes(request.path)
    return list(found), list(found), list(found.values())


def get_attribute(prims: Prims, request: Any) -> Sequence[Any]:
    """The value of an attribute, and its type."""
    kind, value = prims.read(request.path, request.attribute)
    return json.dumps(value), kind


def set_attribute(prims: Prims, request: Any) -> Sequence[Any]:
    """Change an attribute.

    Raises:
        ContextError: the value is not JSON.
    """
    try:
        value = json.loads(request.value)
    except (ValueError, RecursionError) as error:
        raise ContextError(f"the value is not JSON: {error}") from error
    prims.write(request.path, request.attribute, value)
    return ()
