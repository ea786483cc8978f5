"""Services of any type, whose fields are ports: a client, and a server of two nodes that share a handle."""

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
    """A node of one service, whose type its inputs name; the file gives them, for ports are made before wires are read."""

    request: ClassVar[Layout]
    response: ClassVar[Layout]

    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(default="", setup=True, doc="used as it is; prims give services no namespace")
    message_package: String = In(required=True, setup=True, doc="package of the service, such as std_srvs")
    message_subfolder: String = In(default="srv", setup=True, doc="where in the package the service is defined")
    message_name: String = In(required=True, setup=True, doc="such as SetBool")

    def bind(self) -> str:
        """The type of the service that the class was made with.

        Raises:
            ContextError: the inputs name another service by now.
        """
        named = f"{self.message_package}/{self.message_subfolder}/{self.message_name}"
        layout: Layout | None = getattr(self, "request", None) or getattr(self, "response", None)
        expect(layout.message_type.rpartition("_")[0] if layout else None, named)
        return named


class NamedServiceNode(ServiceNode):
    """A node that opens a service."""

    exec_in = ExecIn()
    service_name: String = In(default="/service_name", setup=True, doc="name below nodeNamespace")
    qos_profile: String = In(default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, 10")

    def endpoint(self) -> dict[str, Any]:
        """What the ports say of the service besides its type and name."""
        return {"namespace": self.node_namespace, "qos_profile": self.qos_profile, "ros_context": self.context}


class OgnROS2ServiceServerRequest(NamedServiceNode, type="isaacsim.ros2.bridge.OgnROS2ServiceServerRequest"):
    """Offers a service; the fields of a request are outputs, such as `Request:data` of a SetBool.

    `graphrun nodes ROS2ServiceServerRequest --message std_srvs/srv/SetBool` shows them. Of several requests in a tick each one
    runs what hangs on `onReceived`, oldest first. A ROS2ServiceServerResponse with the same handle answers; a request that is
    followed by another before it was answered never is, which is told.
    """

    on_received = ExecOut(doc="fires for each request")
    server_handle: UInt64 = Out(default=0, doc="for the ROS2ServiceServerResponse that answers")

    server: ServiceServer = Bound()
    logger: Context = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """An output for each field of the request."""
        request, _ = find_service(literals, definitions)
        return {"request": request, **request.ports(Out)}

    def setup(self, context: Context) -> None:
        """Offer the service."""
        self.logger = context
        self.server = context.service_server(self.bind(), self.service_name, **self.endpoint())
        self.server_handle = self.server.handle

    def compute(self) -> Pushes:
        """Deliver what came."""
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
    """Answers the request that a ROS2ServiceServerRequest delivered last; the fields of the response are inputs.

    `graphrun nodes ROS2ServiceServerResponse --message std_srvs/srv/SetBool` shows them. The answer leaves when the tick ends.
    Each request is answered once; without one nothing is sent and nothing fires.
    """

    on_received = ExecIn()
    server_handle: UInt64 = In(required=True, doc="from the ROS2ServiceServerRequest")
    exec_out = ExecOut(doc="fires when an answer was sent")

    door: Context = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """An input for each field of the response."""
        _, response = find_service(literals, definitions)
        return {"response": response, **response.ports(In)}

    def setup(self, context: Context) -> None:
        """See that the server is of the same type."""
        self.door = context
        self.bind()
        self.response.check(self)
        if self.server_handle:
            self.find()

    def find(self) -> ServiceServer:
        """The server of the handle.

        Raises:
            ContextError: there is none, or it is of another type.
        """
        server, service_type = self.door.server(self.server_handle), self.bind()
        if server.service_type != service_type:
            raise ContextError(
                f"it answers {service_type}, and the service {server.service} is {server.service_type}",
                self.message_name,
                "name the same service in both nodes",
            )
        return server

    def compute(self) -> Fire:
        """Answer.

        Raises:
            BadValueError: there is no server of the handle, or the response cannot hold what an input does.
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
    """Calls a service; the fields of the request are inputs, those of the response outputs, such as `Response:success`.

    `graphrun nodes ROS2ServiceClient --message std_srvs/srv/SetBool` shows them. Every execution is a call, also while others
    wait for their answers. A call leaves when the tick ends, or as soon as a server is there; the last ten are kept until then.
    Each answer is put out in a tick of its own, in the order in which they come.
    """

    exec_out = ExecOut(doc="fires for each answer, in a later tick")

    client: ServiceClient = Bound()
    waiting: int = State(default=0)
    answers: deque[Any] = State(factory=deque)

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """An input for each field of the request, an output for each of the response."""
        request, response = find_service(literals, definitions)
        return {"request": request, "response": response, **request.ports(In), **response.ports(Out)}

    def setup(self, context: Context) -> None:
        """Find the service."""
        service_type = self.bind()
        self.request.check(self)
        self.client = context.service_client(service_type, self.service_name, **self.endpoint())
        self.waiting = len(self.answers)

    def compute(self) -> None:
        """Call.

        Raises:
            BadValueError: the request cannot hold what an input does.
        """
        self.request.send(self, self.client.call)
        self.waiting += 1
        self.active = True

    def update(self) -> Fire:
        """Put out the next answer."""
        self.answers.extend(response for _, response in self.client.take())
        if not self.answers:
            return None
        self.response.write(self, self.answers.popleft())
        self.waiting -= 1
        self.active = self.waiting > 0
        return self.exec_out
