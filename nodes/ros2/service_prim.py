"""Services that list prims of the stage, and read and write attributes."""

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
    """Offers services of isaac_ros2_messages to list prims and attributes, and to read and write attributes.

    Values are JSON; quaternions are [w, x, y, z] and angles degrees, as in USD. Attributes are those of the simulation; a write
    to an attribute that cannot change during a simulation is refused. Requests of a tick are answered service by service,
    each in order.
    """

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="used unchanged; empty: `isaac:namespace` of the ancestor prims"
    )
    prims_service_name: String = In(default="get_prims", setup=True, doc="GetPrims: a prim and its descendants")
    get_attributes_service_name: String = In(
        default="get_prim_attributes", setup=True, doc="GetPrimAttributes: names and types"
    )
    get_attribute_service_name: String = In(default="get_prim_attribute", setup=True, doc="GetPrimAttribute: a value")
    set_attribute_service_name: String = In(default="set_prim_attribute", setup=True, doc="SetPrimAttribute: a change")
    qos_profile: String = In(default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, 10")
    exec_out = ExecOut(doc="fires after requests were answered")

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
        """Open one of the services."""
        return context.service_server(
            f"{_PACKAGE}/{name}",
            service,
            namespace=self.node_namespace,
            collects_namespace=True,
            qos_profile=self.qos_profile,
            ros_context=self.context,
        )

    def writes(self) -> Iterable[str]:
        """The attributes of all prims."""
        return WIRED, ANY

    def compute(self) -> Fire:
        """Answer the requests of this tick."""
        fired: Fire = None
        for server, respond in self.served:
            for request_id, request in server.take():
                server.answer(request_id, respond(request))
                fired = self.exec_out
        return fired


def get_prims(prims: Prims, request: Any) -> Any:
    """Answer with the paths and types of a prim and its descendants."""
    response = messages.message_class(f"{_PACKAGE}/GetPrims_Response")
    try:
        found = prims.below(request.path)
    except GraphError as error:
        return response([], [], False, _told(error))
    return response([path for path, _ in found], [kind for _, kind in found], True, "")


def get_attributes(prims: Prims, request: Any) -> Any:
    """Answer with names, display names (equal to the names) and types of a prim's attributes."""
    response = messages.message_class(f"{_PACKAGE}/GetPrimAttributes_Response")
    try:
        found = prims.attributes(request.path)
    except GraphError as error:
        return response([], [], [], False, _told(error))
    return response(list(found), list(found), list(found.values()), True, "")


def get_attribute(prims: Prims, request: Any) -> Any:
    """Answer with the value of an attribute."""
    response = messages.message_class(f"{_PACKAGE}/GetPrimAttribute_Response")
    try:
        kind, value = prims.read(request.path, request.attribute)
    except GraphError as error:
        return response("", "", False, _told(error))
    return response(json.dumps(value), kind, True, "")


def set_attribute(prims: Prims, request: Any) -> Any:
    """Set an attribute and answer with the outcome."""
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
