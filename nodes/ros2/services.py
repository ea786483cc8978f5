"""Nodes for a service client or a service server of any service type, with a port for each field.

A server consists of two nodes that share a handle: ROS2ServiceServerRequest and ROS2ServiceServerResponse.
"""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import Any, ClassVar

from graphengine.format.errors import BadValueError, ContextError
from graphengine.messages.endpoints import ServiceClient, ServiceServer
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Out, Pushes, State, String, UInt64
from graphengine.nodes.ros2.fields import FieldNode, Layout


class ServiceNode(FieldNode):
    """Base of service nodes that have a port for each field of the service type."""

    folder = "srv"
    request: ClassVar[Layout]
    response: ClassVar[Layout]

    context: UInt64 = In(default=0, setup=True, doc="ROS domain: handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(default="", setup=True, doc="ROS namespace; `isaac:namespace` of prims is not added")
    message_package: String = In(required=True, setup=True, doc="package of the service type, such as std_srvs")
    message_subfolder: String = In(default="srv", setup=True, doc="folder of the package that holds the service type")
    message_name: String = In(required=True, setup=True, doc="name of the service type, such as SetBool")


class NamedServiceNode(ServiceNode):
    """Base of nodes that create a service server or client, with inputs for the name and the QoS of the service."""

    exec_in = ExecIn()
    service_name: String = In(default="/service_name", setup=True, doc="name of the service")
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth 10"
    )

    def endpoint(self) -> dict[str, Any]:
        """Return the inputs for namespace, QoS and domain as keyword arguments for the creation of a server or client."""
        return {"namespace": self.node_namespace, "qos_profile": self.qos_profile, "ros_context": self.context}


class OgnROS2ServiceServerRequest(NamedServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceServerRequest"):
    """Creates a service server and outputs the fields of each request, such as `Request:data` of a SetBool.

    `graphrun nodes ROS2ServiceServerRequest --message std_srvs/srv/SetBool` lists these outputs. `onReceived` fires once for each
    request that arrived in the tick, oldest first. A ROS2ServiceServerResponse with the same `serverHandle` sends the response.
    If the next request is output before the response is sent, the earlier request gets no response, and a warning is logged.
    """

    parts: ClassVar = {"request": Out}

    on_received = ExecOut(doc="fires once for each request")
    server_handle: UInt64 = Out(default=0, doc="handle of this server; wire it to a ROS2ServiceServerResponse")

    server: ServiceServer = Bound()
    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Create the service server `serviceName`."""
        self.logger = context
        self.server = context.service_server(self.bind(), self.service_name, **self.endpoint())
        self.server_handle = self.server.handle

    def compute(self) -> Pushes:
        """Set the outputs from each request, and yield the port to fire after each."""
        self.server_handle = self.server.handle
        for request_id, request in self.server.take():
            if self.server.current is not None:
                self.logger.log("warning", f"{self.server.service}: the next request came before a response was sent")
            self.server.current = request_id
            self.request.write(self, request)
            yield self.on_received


class OgnROS2ServiceServerResponse(ServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceServerResponse", gated=True):
    """Responds to the latest request of a ROS2ServiceServerRequest; the fields of the response are inputs.

    `graphrun nodes ROS2ServiceServerResponse --message std_srvs/srv/SetBool` lists these inputs. The response is sent at the end
    of the tick. Each request gets one response. Without a request, the node sends nothing, logs a warning and does not fire.
    """

    parts: ClassVar = {"response": In}

    on_received = ExecIn()
    server_handle: UInt64 = In(required=True, doc="handle of the service server, from a ROS2ServiceServerRequest")
    exec_out = ExecOut(doc="fires when the node has responded to a request")

    door: Context = Bound()

    def setup(self, context: Context) -> None:
        """Check the values of the field inputs and, if `serverHandle` is already set, the service type of the server."""
        self.door = context
        self.bind()
        if self.server_handle:
            self.find()

    def find(self) -> ServiceServer:
        """Return the service server whose handle is `serverHandle`.

        Raises:
            ContextError: no service server has this handle, or the server has another service type.
        """
        server, service_type = self.door.server(self.server_handle), self.response.type_name
        if server.service_type != service_type:
            raise ContextError(
                f"the node is for {service_type}, but the service {server.service} has type {server.service_type}",
                self.message_name,
                "name the same service type in both nodes",
            )
        return server

    def compute(self) -> Fire:
        """Respond to the latest request, or log a warning if there is none.

        Raises:
            BadValueError: no service server has the handle, the server has another service type, or the value of an input does
                not fit its field.
        """
        try:
            server = self.find()
        except ContextError as error:
            legal = "the output serverHandle of a ROS2ServiceServerRequest with the same service type"
            raise BadValueError("serverHandle", self.server_handle, legal) from error
        if server.current is None:
            self.door.log("warning", f"{server.service}: there is no request to answer")
            return None
        self.response.send(self, partial(server.answer, server.current))
        return self.exec_out


class OgnROS2ServiceClient(NamedServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceClient"):
    """Calls a service. The fields of the request are inputs; the fields of the response are outputs, such as `Response:success`.

    `graphrun nodes ROS2ServiceClient --message std_srvs/srv/SetBool` lists these ports. Every execution calls the service, even
    while earlier calls wait for responses. If a server exists, a call is sent at the end of the tick. Otherwise, the last ten
    calls are kept, and sent when a server appears. Responses are output in order of arrival, at most one per tick.
    """

    parts: ClassVar = {"request": In, "response": Out}

    exec_out = ExecOut(doc="fires once for each response, in a tick after the call")

    client: ServiceClient = Bound()
    waiting: int = State(default=0)
    answers: deque[Any] = State(factory=deque)

    def setup(self, context: Context) -> None:
        """Create the client of the service `serviceName`."""
        self.client = context.service_client(self.bind(), self.service_name, **self.endpoint())
        self.waiting = len(self.answers)

    def compute(self) -> None:
        """Call the service.

        Raises:
            BadValueError: the value of an input does not fit its field of the request.
        """
        self.request.send(self, self.client.call)
        self.waiting += 1
        self.active = True

    def update(self) -> Fire:
        """Output the next response, if one has arrived, and fire."""
        self.answers.extend(response for _, response in self.client.take())
        if not self.answers:
            return None
        self.response.write(self, self.answers.popleft())
        self.waiting -= 1
        self.active = self.waiting > 0
        return self.exec_out
