"""What a node is handed out of the network: topics and services under their full names, closed when it is done with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Unpack

from graphengine.format.errors import ContextError, TopicError
from graphengine.messages import names, qos
from graphengine.messages.endpoints import (
    Closable,
    EndpointClaim,
    Publisher,
    QoS,
    ServiceClient,
    ServiceServer,
    Subscription,
)
from graphengine.node.context import ServiceOptions, TopicOptions
from graphengine.runtime.node_context.services import Services


class _Closing:
    """Something to be done once, when what a node was handed out is closed."""

    def __init__(self, function: Callable[[], None]) -> None:
        self.close = function


class OwnedEndpoints:
    """Part of a node's context. Claims tell everybody else what there is."""

    def __init__(self, services: Services, graph: str, prim_path: str, rate: float | None) -> None:
        self._services = services
        self.prim_path = prim_path
        self._graph = graph
        self._rate = rate
        self._owned: list[Closable] = []
        self._claims: list[EndpointClaim] = []
        self._servers: list[int] = []

    def close(self) -> None:
        """Close what was handed out, before the node is set up again or when its session ends."""
        for endpoint in self._owned:
            endpoint.close()
        self._owned.clear()
        for claim in self._claims:
            self._services.claims.remove(claim)
        self._claims.clear()
        for handle in self._servers:
            del self._services.servers[handle]
        self._servers.clear()

    def when_closed(self, function: Callable[[], None]) -> None:
        """Have something done at the end."""
        self._owned.append(_Closing(function))

    def ros_context(self, domain_id: int, use_environment: bool) -> int:
        """Handle of a ROS 2 domain: the domain's number and one."""
        environment = self._services.domain_from_environment
        domain = environment if use_environment and environment is not None else domain_id
        if not 0 <= domain <= 232:
            raise TopicError(f"{domain} is not a ROS 2 domain", domain_id, "legal: 0 to 232")
        return domain + 1

    def _claim(
        self,
        direction: str,
        message_type: str,
        topic: str,
        start: str = "",
        *,
        namespace: str = "",
        outermost_namespace: bool = False,
        qos_profile: str = "",
        queue_size: int = 10,
        latched: bool = False,
        **facts: Any,
    ) -> EndpointClaim:
        quality = qos.parse_qos(qos_profile, queue_size, latched)
        full = names.full_topic(namespace or self._collected(start or self.prim_path, outermost_namespace), topic)
        return self._note(direction, message_type, full, qos=quality, latched=latched, **facts)

    def _collected(self, start: str, outermost: bool = False) -> str:
        """The namespace that prims give, from one up to the root."""
        return names.join_namespaces(self._services.stage.namespaces(start), outermost)

    def _note(self, direction: str, message_type: str, full: str, **facts: Any) -> EndpointClaim:
        """A claim of the node, which ends with what it was handed out."""
        claim = EndpointClaim(self.prim_path, self._graph, full, message_type, direction, **facts)
        self._services.claims.append(claim)
        self._claims.append(claim)
        return claim

    def publisher(
        self,
        message_type: str,
        topic: str,
        *,
        namespace_from: str = "",
        latched: bool = False,
        rate: float | None = None,
        frame_id: str = "",
        transforms: Sequence[tuple[str, str]] = (),
        **options: Unpack[TopicOptions],
    ) -> Publisher:
        """A topic to write to."""
        rate = rate if rate is not None else self._rate
        facts: dict[str, Any] = {"rate": rate, "frame_id": frame_id, "transforms": tuple(transforms)}
        claim = self._claim("publish", message_type, topic, namespace_from, latched=latched, **options, **facts)
        publisher = self._services.network.publisher(claim)
        self._owned.append(publisher)
        return publisher

    def subscription(
        self, message_type: str, topic: str, *, alternatives: Sequence[str] = (), **options: Unpack[TopicOptions]
    ) -> Subscription:
        """A topic to read from."""
        claim = self._claim("subscribe", message_type, topic, **options, alternatives=tuple(alternatives))
        subscription = self._services.network.subscription(claim)
        self._owned.append(subscription)
        return subscription

    def _service(
        self,
        direction: str,
        service_type: str,
        service: str,
        *,
        namespace: str = "",
        collects_namespace: bool = False,
        qos_profile: str = "",
        ros_context: int = 0,
    ) -> EndpointClaim:
        if not namespace and collects_namespace:
            namespace = self._collected(self.prim_path)
        full = names.full_topic(namespace, service, "service name")
        quality = qos.parse_qos(qos_profile, QoS().depth, False)
        return self._note(direction, service_type, full, qos=quality, ros_context=ros_context)

    def service_server(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceServer:
        """A service to offer."""
        claim = self._service("serve", service_type, service, **options)
        handles = self._services.handles
        handle = handles.setdefault((self.prim_path, len(self._servers)), len(handles) + 1)
        server = self._services.network.server(claim, handle)
        self._owned.append(server)
        self._servers.append(handle)
        self._services.servers[handle] = server
        return server

    def service_client(self, service_type: str, service: str, **options: Unpack[ServiceOptions]) -> ServiceClient:
        """A service to call."""
        client = self._services.network.client(self._service("call", service_type, service, **options))
        self._owned.append(client)
        return client

    def server(self, handle: int) -> ServiceServer:
        """The server of that handle.

        Raises:
            ContextError: there is none.
        """
        if handle not in self._services.servers:
            raise ContextError(
                f"no service server has the handle {handle}",
                handle,
                "wire serverHandle from a ROS2ServiceServerRequest",
            )
        return self._services.servers[handle]
