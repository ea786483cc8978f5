"""Creates the publishers, subscriptions and services of a node, and destroys them when the node is set up again or removed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any, TypedDict, TypeVar, Unpack

from graphengine.format.errors import ContextError, TopicError
from graphengine.messages import names, qos
from graphengine.messages.endpoints import EndpointClaim, Publisher, ServiceClient, ServiceServer, Subscription
from graphengine.node.context.frame_names import frame_prefix, full_frame
from graphengine.node.context.published_transform import PublishedTransform
from graphengine.node.context.session_services import Services

E = TypeVar("E", Publisher, Subscription, ServiceClient)


class EndpointOptions(TypedDict, total=False):
    """Options that topics and services have in common."""

    namespace: str
    """Namespace of the topic or service. A namespace that is not empty replaces the namespaces of the ancestor prims."""
    qos_profile: str
    """QoS profile as JSON. An empty string means reliable, volatile and keep-last."""
    ros_context: int
    """Handle of a ROS 2 domain from `Context.ros_context`; 0 is the session's domain."""


class TopicOptions(EndpointOptions, total=False):
    """Options of a topic. If `namespace` is empty, the topic's namespace is the joined namespaces of the ancestor prims."""

    outermost_namespace: bool
    """Whether to use only the namespace of the outermost ancestor prim that has one, as TF nodes do.

    In a scene with `tf: global`, a topic with this option has no namespace, whatever `namespace` says.
    """
    queue_size: int
    """History depth, 10 by default; used only if `qos_profile` is empty."""


class ServiceOptions(EndpointOptions, total=False):
    """Options of a service."""

    collects_namespace: bool
    """Whether to join the namespaces of the node's ancestor prims if `namespace` is empty."""


class OwnedEndpoints:
    """The publishers, subscriptions, service servers and service clients of one node."""

    def __init__(self, services: Services, graph: str, prim_path: str, rate: float | None) -> None:
        self._services = services
        self.prim_path = prim_path
        self._graph = graph
        self._rate = rate
        self._servers = 0
        self._closing: list[Callable[[], object]] = []
        """Functions that destroy the endpoints, in the order in which the endpoints were created."""

    def close(self) -> None:
        """Destroy all endpoints. The engine calls this before it sets the node up again, and when it removes the node."""
        while self._closing:
            self._closing.pop(0)()
        self._servers = 0

    def when_closed(self, function: Callable[[], None]) -> None:
        """Register a function that is called once: before the node is set up again, or when the node is removed."""
        self._closing.append(function)

    def _own(self, endpoint: E) -> E:
        """Return an endpoint, after registering that `close` destroys it."""
        self._closing.append(endpoint.close)
        return endpoint

    def ros_context(self, domain_id: int, use_environment: bool) -> int:
        """Return the handle of a ROS 2 domain: the domain ID plus 1. The handle 0 means the session's own domain.

        Args:
            domain_id: ID of the domain, 0 to 232.
            use_environment: whether the environment variable `ROS_DOMAIN_ID`, if it is set, replaces `domain_id`.

        Raises:
            TopicError: the ID is out of range.
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
        """Register and return the claim of one endpoint: its name, type and QoS. `close` removes the claim."""
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
        """Remove this claim. Claims are compared by identity: during a reload, the replaced node may have an equal claim."""
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
        """Create a publisher on a topic.

        In a scene with `tf: global`, a namespace is put before the frame names in the arguments, as `frame_name` describes. The
        publisher's `claim` has the prefixed names, which the node must write into its messages. Names from
        `transform_tree` and `robot_description` already have the prefix.

        Args:
            message_type: ROS 2 name of the message type, such as `nav_msgs/msg/Odometry`.
            topic: name of the topic in its namespace; leading and trailing non-alphanumerics are dropped.
            namespace_from: path of the prim at which the search for namespaces starts; it continues with the prim's ancestors.
                The topic's namespace joins all namespaces found; the frame prefix is the outermost one. Empty: start at the
                node's prim.
            latched: whether to use durability transient local and history depth 1, which then override the QoS profile.
            rate: messages per second; None if a message is published at each execution of the node.
            frame_id: frame in the message headers.
            child_frame_id: child frame in the messages, as in odometry.
            transforms: (parent frame, child frame) of each transform that the node will publish.
            options: see `TopicOptions`.

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
        return self._own(self._services.network.publisher(claim))

    def published_transform(self, beside: EndpointClaim, parent: str, children: Collection[str]) -> PublishedTransform:
        """Return a reader of a transform that another node of this session publishes.

        The reader takes messages only from publishers with the topic and ROS domain of `beside`, a publisher of the calling node.

        Args:
            beside: attribute `claim` of the node's own publisher, which describes its topic and domain.
            parent: published name of the parent frame.
            children: published names of the child frames; a transform to any of them is used.
        """
        return PublishedTransform(self._services, beside, parent, children)

    def frame_name(self, frame: str, *, namespace_from: str = "", namespace: str = "") -> str:
        """Return the name under which a frame is published: `namespace/frame` with `tf: global`, otherwise `frame`.

        Of the prim at `namespace_from` and its ancestors, the outermost one that has a namespace gives the namespace.
        Shared frames such as `map`, and frames that already have a prefix, are returned unchanged.

        Args:
            frame: name of the frame.
            namespace_from: path of the prim at which the search for the namespace starts; empty: start at the node's prim.
            namespace: namespace to use if neither this prim nor any of its ancestors has one.
        """
        stage = self._services.stage
        return str(full_frame(stage, frame, frame_prefix(stage, namespace_from or self.prim_path, namespace)))

    def subscription(
        self, message_type: str, topic: str, *, alternatives: Sequence[str] = (), **options: Unpack[TopicOptions]
    ) -> Subscription:
        """Create a subscription to a topic. The exceptions are those of `publisher`.

        Args:
            message_type: ROS 2 name of the expected message type.
            topic: name of the topic in its namespace.
            alternatives: other message types that the node accepts; used if a publisher on the topic has one of these types.
            options: see `TopicOptions`.
        """
        claim = self._claim("subscribe", message_type, topic, **options, alternatives=tuple(alternatives))
        return self._own(self._services.network.subscription(claim))

    def service_server(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceServer:
        """Create a service server.

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
        """Create a service client. The arguments and the exceptions are those of `service_server`."""
        return self._own(self._services.network.client(self._claim("call", service_type, service, **options)))

    def server(self, handle: int) -> ServiceServer:
        """Return the service server with this handle. It may belong to any node of the session.

        Raises:
            ContextError: no service server has the handle.
        """
        if handle not in self._services.servers:
            remedy = "wire serverHandle from a ROS2ServiceServerRequest"
            raise ContextError(f"no service server has the handle {handle}", handle, remedy)
        return self._services.servers[handle][-1]
