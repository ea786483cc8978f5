"""Opens topics and services for a node, and closes them when the node is set up again or the session ends."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any, TypedDict, Unpack

from graphengine.format.errors import ContextError, TopicError
from graphengine.messages import names, qos
from graphengine.messages.endpoints import EndpointClaim, Publisher, ServiceClient, ServiceServer, Subscription
from graphengine.node.context.frame_names import frame_prefix, full_frame
from graphengine.node.context.published_transform import PublishedTransform
from graphengine.node.context.session_services import Services


class EndpointOptions(TypedDict, total=False):
    """Options of a topic or service besides its type and name."""

    namespace: str
    """Namespace of the topic or service, used unchanged if not empty."""
    qos_profile: str
    """QoS profile as JSON; if empty: reliable, volatile, keep-last."""
    ros_context: int
    """Domain handle that `Context.ros_context` returned; 0: the session's domain."""


class TopicOptions(EndpointOptions, total=False):
    """Options of a topic. If `namespace` is empty, the namespaces of the ancestor prims are joined instead."""

    outermost_namespace: bool
    """Use only the namespace of the outermost ancestor prim that has one, as TF nodes do; none in a scene with `tf: global`."""
    queue_size: int
    """History depth if `qos_profile` is empty; 10 by default."""


class ServiceOptions(EndpointOptions, total=False):
    """Options of a service."""

    collects_namespace: bool
    """Whether to join the namespaces of the node's ancestor prims if `namespace` is empty."""


class OwnedEndpoints:
    """The publishers, subscriptions and services of a node; `graphrun topics` lists their declarations."""

    def __init__(self, services: Services, graph: str, prim_path: str, rate: float | None) -> None:
        self._services = services
        self.prim_path = prim_path
        self._graph = graph
        self._rate = rate
        self._servers = 0
        self._closing: list[Callable[[], object]] = []
        """Functions that close the endpoints, in the order in which these were opened."""

    def close(self) -> None:
        """Close all endpoints; the engine calls it before the node is set up again and when the session ends."""
        while self._closing:
            self._closing.pop(0)()
        self._servers = 0

    def when_closed(self, function: Callable[[], None]) -> None:
        """Call a function when the node is set up again, and when the session ends."""
        self._closing.append(function)

    def ros_context(self, domain_id: int, use_environment: bool) -> int:
        """Return the handle of a ROS 2 domain: its id plus 1. The handle 0 means the session's own domain.

        Args:
            domain_id: id of the domain, 0 to 232.
            use_environment: use the environment variable `ROS_DOMAIN_ID` instead of `domain_id`, if it is set.

        Raises:
            TopicError: the id is out of range.
        """
        environment = self._services.domain_from_environment
        domain = environment if use_environment and environment is not None else domain_id
        if not 0 <= domain <= 232:
            raise TopicError(f"{domain} is not a ROS 2 domain", domain_id, "legal: 0 to 232")
        return domain + 1

    def _claim(
        self,
        direction: str,
        message_type: str,
        name: str,
        start: str = "",
        *,
        namespace: str = "",
        collects_namespace: bool | None = None,
        outermost_namespace: bool = False,
        qos_profile: str = "",
        queue_size: int = 10,
        latched: bool = False,
        **facts: Any,
    ) -> EndpointClaim:
        """Register and return the claim of one endpoint: its declaration. Closing the endpoints removes it."""
        is_service = direction in ("serve", "call")
        quality = qos.parse_qos(qos_profile, queue_size, latched)
        if outermost_namespace and self._services.stage.global_tf:
            namespace = ""
        elif not namespace and (not is_service if collects_namespace is None else collects_namespace):
            above = self._services.stage.namespaces(start or self.prim_path)
            namespace = names.join_namespaces(above, outermost_namespace)
        full = names.full_topic(namespace, name, "service name" if is_service else "topic name")
        claim = EndpointClaim(
            self.prim_path, self._graph, full, message_type, direction, quality, latched=latched, **facts
        )
        self._services.claims.append(claim)
        self._closing.append(partial(self._withdraw_claim, claim))
        return claim

    def _withdraw_claim(self, claim: EndpointClaim) -> None:
        """Remove this claim object, not an equal claim of a node that is being replaced."""
        claims = self._services.claims
        del claims[next(index for index, one in enumerate(claims) if one is claim)]

    def publisher(
        self,
        message_type: str,
        topic: str,
        *,
        namespace_from: str = "",
        latched: bool = False,
        rate: float | None = None,
        frame_id: str = "",
        child_frame_id: str = "",
        transforms: Sequence[tuple[str, str]] = (),
        **options: Unpack[TopicOptions],
    ) -> Publisher:
        """Open a publisher on a topic.

        Args:
            message_type: ROS 2 name of the message type, such as `nav_msgs/msg/Odometry`.
            topic: name of the topic in its namespace; leading and trailing non-alphanumerics are dropped.
            namespace_from: path of a prim; its namespace and those of its ancestors are joined. Empty: the node's prim.
            latched: use durability transient local and depth 1; overrides the QoS profile.
            rate: messages per second, if this differs from the rate at which the node is executed.
            frame_id: frame in the message headers.
            child_frame_id: child frame in the messages, such as that of odometry.
            transforms: (parent, child) pairs that will be published.
            options: see `TopicOptions`.

        In a scene with `tf: global`, frame names get a prefix: take the names in messages from the publisher's `claim`. Names
        from `transform_tree` and `robot_description` already have the prefix.

        Raises:
            TopicError: the name, the namespace or the QoS profile is not valid.
        """
        name = partial(self.frame_name, namespace_from=namespace_from, namespace=options.get("namespace", ""))
        facts: dict[str, Any] = {
            "rate": rate if rate is not None else self._rate,
            "frame_id": name(frame_id),
            "child_frame_id": name(child_frame_id),
            "transforms": tuple((name(parent), name(child)) for parent, child in transforms),
        }
        claim = self._claim("publish", message_type, topic, namespace_from, latched=latched, **options, **facts)
        publisher = self._services.network.publisher(claim)
        self._closing.append(publisher.close)
        return publisher

    def published_transform(self, beside: EndpointClaim, parent: str, children: Collection[str]) -> PublishedTransform:
        """Return a reader for the transform from a parent frame to one of several child frames, published in this session.

        Args:
            beside: claim of the node's own publisher, which has the same topic as the transform.
            parent: published name of the parent frame.
            children: published names of the possible child frames.
        """
        return PublishedTransform(self._services, beside, parent, children)

    def frame_name(self, frame: str, *, namespace_from: str = "", namespace: str = "") -> str:
        """Return the published name of a frame; the arguments are those of `publisher`."""
        stage = self._services.stage
        return str(full_frame(stage, frame, frame_prefix(stage, namespace_from or self.prim_path, namespace)))

    def subscription(
        self, message_type: str, topic: str, *, alternatives: Sequence[str] = (), **options: Unpack[TopicOptions]
    ) -> Subscription:
        """Open a subscription to a topic. Takes arguments of `publisher` and raises the same errors.

        `alternatives` are message types that replace `message_type` if the topic is published with one of them.
        """
        claim = self._claim("subscribe", message_type, topic, **options, alternatives=tuple(alternatives))
        subscription = self._services.network.subscription(claim)
        self._closing.append(subscription.close)
        return subscription

    def service_server(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceServer:
        """Open a server of a service.

        Args:
            service_type: ROS 2 name of the service type, such as `std_srvs/srv/SetBool`.
            service: name of the service in its namespace; leading and trailing non-alphanumerics are dropped.
            options: see `ServiceOptions`.

        Raises:
            TopicError: the name, the namespace or the QoS profile is not valid.
        """
        claim = self._claim("serve", service_type, service, **options)
        handles = self._services.handles
        handle = handles.setdefault((self.prim_path, self._servers), len(handles) + 1)
        server = self._services.network.server(claim, handle)
        self._closing += (server.close, partial(self._withdraw, handle, server))
        self._servers += 1
        self._services.servers.setdefault(handle, []).append(server)
        return server

    def _withdraw(self, handle: int, server: ServiceServer) -> None:
        self._services.servers[handle].remove(server)
        if not self._services.servers[handle]:
            del self._services.servers[handle]

    def service_client(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceClient:
        """Open a client of a service. Takes the same arguments and raises the same errors as `service_server`."""
        client = self._services.network.client(self._claim("call", service_type, service, **options))
        self._closing.append(client.close)
        return client

    def server(self, handle: int) -> ServiceServer:
        """Return the service server with this handle; any node may have opened it.

        Raises:
            ContextError: no open server has the handle.
        """
        if handle not in self._services.servers:
            raise ContextError(
                f"no service server has the handle {handle}",
                handle,
                "wire serverHandle from a ROS2ServiceServerRequest",
            )
        return self._services.servers[handle][-1]
