"""Services that show the prims of the stage, and change some of their attributes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.endpoints import ServiceServer
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Prims, String, UInt64
from graphengine.nodes.touched import ANY, WIRED

_PACKAGE = "isaac_ros2_messages/srv"


class ROS2ServicePrim(Node, type="isaacsim.ros2.bridge.ROS2ServicePrim", gated=True):
    """Lists prims and their attributes, reads an attribute and writes one, for services of isaac_ros2_messages.

    Values are JSON, quaternions [w, x, y, z] and angles degrees, as USD has them. Attributes are the ones that stand for
    something here; those that cannot be changed while the simulation runs answer so. Requests of a tick are answered service
    by service, each in order.
    """

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="used as it is; empty for `isaac:namespace` of the prims above"
    )
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
        prims, offer = context.stage(), partial(self.offer, context)
        self.served = (
            (offer("GetPrims", self.prims_service_name), partial(get_prims, prims)),
            (offer("GetPrimAttributes", self.get_attributes_service_name), partial(get_attributes, prims)),
            (offer("GetPrimAttribute", self.get_attribute_service_name), partial(get_attribute, prims)),
            (offer("SetPrimAttribute", self.set_attribute_service_name), partial(set_attribute, prims)),
        )

    def offer(self, context: Context, name: str, service: str) -> ServiceServer:
        """One of the services."""
        return context.service_server(
            f"{_PACKAGE}/{name}",
            service,
            namespace=self.node_namespace,
            collects_namespace=True,
            qos_profile=self.qos_profile,
            ros_context=self.context,
        )

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


def get_prims(prims: Prims, request: Any) -> Any:
    """Paths and types of a prim and of all below it."""
    response = messages.message_class(f"{_PACKAGE}/GetPrims_Response")
    try:
        found = prims.below(request.path)
    except GraphError as error:
        return response([], [], False, _told(error))
    return response([path for path, _ in found], [kind for _, kind in found], True, "")


def get_attributes(prims: Prims, request: Any) -> Any:
    """Names and types of a prim's attributes; they are displayed by their names."""
    response = messages.message_class(f"{_PACKAGE}/GetPrimAttributes_Response")
    try:
        found = prims.attributes(request.path)
    except GraphError as error:
        return response([], [], [], False, _told(error))
    return response(list(found), list(found), list(found.values()), True, "")


def get_attribute(prims: Prims, request: Any) -> Any:
    """The value of an attribute."""
    response = messages.message_class(f"{_PACKAGE}/GetPrimAttribute_Response")
    try:
        kind, value = prims.read(request.path, request.attribute)
    except GraphError as error:
        return response("", "", False, _told(error))
    return response(json.dumps(value), kind, True, "")


def set_attribute(prims: Prims, request: Any) -> Any:
    """Change an attribute."""
    response = messages.message_class(f"{_PACKAGE}/SetPrimAttribute_Response")
    try:
        value = json.loads(request.value)
    except (ValueError, RecursionError) as error:
        return response(False, f"the value is not JSON: {error}")
    try:
        prims.write(request.path, request.attribute, value)
    except GraphError as error:
        return response(False, _told(error))
    return response(True, "")


def _told(error: GraphError) -> str:
    return "; ".join(line.strip() for line in str(error).splitlines())
