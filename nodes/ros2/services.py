"""Services of any type, with a port for each field: a client, and a server of two nodes that share a handle."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

from graphengine.format.errors import BadValueError, ContextError
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import ServiceClient, ServiceServer
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, Pushes, State, String, UInt64
from graphengine.nodes.ros2.fields import Layout, expect, find_service


class ServiceNode(Node):
    """Base of nodes for one service of any type, which the graph file sets: ports are made before wires are read."""

    request: ClassVar[Layout]
    response: ClassVar[Layout]

    context: UInt64 = In(default=0, setup=True, doc="domain handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(default="", setup=True, doc="ROS namespace; `isaac:namespace` of prims is not added")
    message_package: String = In(required=True, setup=True, doc="package of the service type, such as std_srvs")
    message_subfolder: String = In(default="srv", setup=True, doc="folder of the service type in the package")
    message_name: String = In(required=True, setup=True, doc="name of the service type, such as SetBool")

    def bind(self) -> str:
        """Return the service type that the inputs name, such as std_srvs/srv/SetBool.

        Raises:
            ContextError: the ports were made for another service type.
        """
        layout: Layout | None = getattr(self, "request", None) or getattr(self, "response", None)
        return expect(layout, self.message_package, self.message_subfolder, self.message_name)


class NamedServiceNode(ServiceNode):
    """Base of nodes that open a service."""

    exec_in = ExecIn()
    service_name: String = In(default="/service_name", setup=True, doc="name of the service")
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth 10"
    )

    def endpoint(self) -> dict[str, Any]:
        """Return the options of the service that the inputs set: namespace, QoS and domain."""
        return {"namespace": self.node_namespace, "qos_profile": self.qos_profile, "ros_context": self.context}


class OgnROS2ServiceServerRequest(NamedServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceServerRequest"):
    """Offers a service; the fields of a request are outputs, such as `Request:data` of a SetBool.

    `graphrun nodes ROS2ServiceServerRequest --message std_srvs/srv/SetBool` lists these outputs. Each request that arrived in a
    tick fires `onReceived` once, oldest first. A ROS2ServiceServerResponse with the same `serverHandle` sends the response. If
    the next request comes before the response, the earlier request never gets a response, and a warning is logged.
    """

    on_received = ExecOut(doc="fires for each request")
    server_handle: UInt64 = Out(default=0, doc="handle of this server; wire it to a ROS2ServiceServerResponse")

    server: ServiceServer = Bound()
    logger: Context = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Make an output for each field of the request."""
        request, _ = find_service(literals, definitions)
        return {"request": request, **request.ports(Out)}

    def setup(self, context: Context) -> None:
        """Offer the service."""
        self.logger = context
        self.server = context.service_server(self.bind(), self.service_name, **self.endpoint())
        self.server_handle = self.server.handle

    def compute(self) -> Pushes:
        """Yield once for each request, after setting the outputs."""
        self.server_handle = self.server.handle
        for request_id, request in self.server.take():
            if self.server.current is not None:
                self.logger.log(
                    "warning", f"{self.server.service}: a request was not answered before the next one came"
                )
            self.server.current = request_id
            self.request.write(self, request)
            yield self.on_received


class OgnROS2ServiceServerResponse(ServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceServerResponse", gated=True):
    """Responds to the latest request of a ROS2ServiceServerRequest; the fields of the response are inputs.

    `graphrun nodes ROS2ServiceServerResponse --message std_srvs/srv/SetBool` lists these inputs. The response is sent when the
    tick ends. Each request gets one response; without a request, nothing is sent and nothing fires.
    """

    on_received = ExecIn()
    server_handle: UInt64 = In(required=True, doc="handle from the ROS2ServiceServerRequest")
    exec_out = ExecOut(doc="fires after a response")

    door: Context = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Make an input for each field of the response."""
        _, response = find_service(literals, definitions)
        return {"response": response, **response.ports(In)}

    def setup(self, context: Context) -> None:
        """Check that the server has the same type, if its handle is known."""
        self.door = context
        self.bind()
        self.response.check(self)
        if self.server_handle:
            self.find()

    def find(self) -> ServiceServer:
        """Return the service server whose handle is `serverHandle`.

        Raises:
            ContextError: no server has the handle, or its type differs.
        """
        server, service_type = self.door.server(self.server_handle), self.bind()
        if server.service_type != service_type:
            raise ContextError(
                f"the node is for {service_type}, but the service {server.service} has type {server.service_type}",
                self.message_name,
                "name the same service in both nodes",
            )
        return server

    def compute(self) -> Fire:
        """Respond to the latest request.

        Raises:
            BadValueError: no server has the handle, or the response cannot hold an input's value.
        """
        try:
            server = self.find()
        except ContextError as error:
            raise BadValueError("serverHandle", self.server_handle) from error
        if server.current is None:
            self.door.log("warning", f"{server.service}: there is no request to answer")
            return None
        self.response.send(self, partial(server.answer, server.current))
        return self.exec_out


class OgnROS2ServiceClient(NamedServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceClient"):
    """Calls a service; the request's fields are inputs, the response's fields are outputs, such as `Response:success`.

    `graphrun nodes ROS2ServiceClient --message std_srvs/srv/SetBool` lists these ports. Every execution calls the service, even
    while other calls wait for responses. A call is sent at the end of the tick if a server exists, otherwise when one appears;
    until then, the last ten calls are kept. Each tick outputs at most one response, in order of arrival.
    """

    exec_out = ExecOut(doc="fires once for each response, in a tick after the call")

    client: ServiceClient = Bound()
    waiting: int = State(default=0)
    answers: deque[Any] = State(factory=deque)

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Make an input for each field of the request and an output for each field of the response."""
        request, response = find_service(literals, definitions)
        return {"request": request, "response": response, **request.ports(In), **response.ports(Out)}

    def setup(self, context: Context) -> None:
        """Open the client."""
        service_type = self.bind()
        self.request.check(self)
        self.client = context.service_client(service_type, self.service_name, **self.endpoint())
        self.waiting = len(self.answers)

    def compute(self) -> None:
        """Call the service.

        Raises:
            BadValueError: the request cannot hold an input's value.
        """
        self.request.send(self, self.client.call)
        self.waiting += 1
        self.active = True

    def update(self) -> Fire:
        """Output the next response and fire."""
        self.answers.extend(response for _, response in self.client.take())
        if not self.answers:
            return None
        self.response.write(self, self.answers.popleft())
        self.waiting -= 1
        self.active = self.waiting > 0
        return self.exec_out
