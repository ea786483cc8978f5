"""Opens action servers and clients for a node, and closes them when the node is set up again or the session ends."""

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
    """The action servers and clients of a node. An action consists of three services and two topics, which the node owns too."""

    clock: Clock

    def action_server(self, action_type: str, action: str, **options: Unpack[ServiceOptions]) -> ActionServer:
        """Open an action server; a node of a reloaded graph takes over the open server of its predecessor with its goals.

        Args:
            action_type: ROS 2 name of the action type, such as `control_msgs/action/FollowJointTrajectory`.
            action: name of the action in its namespace; leading and trailing non-alphanumerics are dropped.
            options: see `ServiceOptions`; the QoS profile applies to the services.

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
        """Open an action client. Takes the same arguments and raises the same errors as `action_server`."""
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
        """Return the action server with this handle; any node may have opened it.

        Raises:
            ContextError: no open action server has the handle.
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
        """Return functions that open one service or one topic of an action, selected by its role, such as `send_goal`."""
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
        """Return the open action that has these endpoints, or else `made`, and register its release.

        The action is released before its endpoints are closed, whose entries in `_closing` begin at index `first`.
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
