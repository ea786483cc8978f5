"""Creates the action servers and action clients of a node, and destroys them together with the node's other endpoints."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, Unpack

from graphengine.format.errors import ContextError
from graphengine.messages import goals, names
from graphengine.messages.action_client import ActionClient, ClientEndpoints
from graphengine.messages.actions import ActionServer, ServerEndpoints
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import qos_json
from graphengine.node.clock import Clock
from graphengine.node.context.endpoint_access import OwnedEndpoints, ServiceOptions

A = TypeVar("A", ActionServer, ActionClient)


class OwnedActions(OwnedEndpoints):
    """The action servers and action clients of a node, with the three services and two topics of each action."""

    clock: Clock

    def action_server(self, action_type: str, action: str, **options: Unpack[ServiceOptions]) -> ActionServer:
        """Create an action server.

        When a graph is reloaded, the new node gets the existing server of the node that it replaces, including the active goals.

        Args:
            action_type: ROS 2 name of the action type, such as `control_msgs/action/FollowJointTrajectory`.
            action: name of the action in its namespace; leading and trailing non-alphanumerics are dropped.
            options: see `ServiceOptions`; the QoS profile applies to the action's services, not to its topics.

        Raises:
            TopicError: the name, the namespace or the QoS profile is not valid.
        """
        first, network, clock = len(self._closing), self._services.network, self.clock
        service, topic = self._parts(action_type, action, options)
        endpoints = ServerEndpoints(
            service(self.service_server, "send_goal"),
            service(self.service_server, "cancel_goal"),
            service(self.service_server, "get_result"),
            topic("publish", network.publisher, "feedback", goals.FEEDBACK_QOS),
            topic("publish", network.publisher, "status", goals.STATUS_QOS),
        )
        full = names.action_of(endpoints.send_goal.service)
        made = ActionServer(full, action_type, endpoints, lambda: clock.time, network.definitions)
        return self._hold(ActionServer, made, first)

    def action_client(self, action_type: str, action: str, **options: Unpack[ServiceOptions]) -> ActionClient:
        """Create an action client. The arguments and the exceptions are those of `action_server`."""
        first, network = len(self._closing), self._services.network
        service, topic = self._parts(action_type, action, options)
        endpoints = ClientEndpoints(
            service(self.service_client, "send_goal"),
            service(self.service_client, "cancel_goal"),
            service(self.service_client, "get_result"),
            topic("subscribe", network.subscription, "feedback", goals.FEEDBACK_READER_QOS),
            topic("subscribe", network.subscription, "status", goals.STATUS_QOS),
        )
        full = names.action_of(endpoints.send_goal.service)
        made = ActionClient(full, action_type, endpoints, network.definitions, self.prim_path, network.identity)
        return self._hold(ActionClient, made, first)

    def action(self, handle: int) -> ActionServer:
        """Return the action server with this handle. It may belong to any node of the session.

        Raises:
            ContextError: no action server has the handle.
        """
        servers = [one for one in self._services.actions if isinstance(one, ActionServer) and one.handle == handle]
        if not servers:
            raise ContextError(
                f"no action server has the handle {handle}", handle, "wire serverHandle from a ROS2ActionServerGoal"
            )
        return servers[-1]

    def _parts(
        self, action_type: str, action: str, options: ServiceOptions
    ) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Return two functions: the first creates a service of the action, the second a topic endpoint.

        Both take the role of the endpoint in the action, such as `send_goal` or `feedback`.
        """
        names.full_topic(options.get("namespace", ""), action, "action name")
        parts = goals.parts(names.strip(action), action_type)

        def service(open_service: Callable[..., Any], role: str) -> Any:
            return open_service(parts[role].message_type, parts[role].name, **options)

        def topic(direction: str, open_topic: Callable[..., Any], role: str, quality: QoS) -> Any:
            chosen: dict[str, Any] = {"collects_namespace": False, **options, "qos_profile": qos_json(quality)}
            claim = self._claim(direction, parts[role].message_type, parts[role].name, **chosen)
            end = open_topic(claim)
            self._closing.append(end.close)
            return end

        return service, topic

    def _hold(self, kind: type[A], made: A, first: int) -> A:
        """Register the node as a holder of the action, and return the action.

        If an action with the same endpoints exists, because the graph is being reloaded, it is returned in place of `made`. The
        node releases the action before it destroys the endpoints; their entries in `_closing` begin at index `first`.
        """
        actions = self._services.actions
        held = next((one for one in actions if isinstance(one, kind) and one.has(made.endpoints)), None)
        if held is None:
            held = made
            actions.append(made)
        else:
            held.holders += 1
        self._closing.insert(first, partial(self._release, held))
        return held

    def _release(self, action: ActionServer | ActionClient) -> None:
        if action.close():
            self._services.actions.remove(action)
