"""Creates the action servers and action clients of a node, and destroys them together with the node's other endpoints."""

from __future__ import annotations

from functools import partial
from typing import Any, TypeVar, Unpack

from graphengine.format.errors import ContextError
from graphengine.messages import goals, names
from graphengine.messages.action_client import ActionClient, ClientEndpoints
from graphengine.messages.actions import ActionServer, ServerEndpoints
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
        first, clock = len(self._closing), self.clock
        endpoints = ServerEndpoints(*self._endpoints(action_type, action, options, serves=True))
        full = names.action_of(endpoints.send_goal.service)
        made = ActionServer(full, action_type, endpoints, lambda: clock.time, self._services.network.definitions)
        return self._hold(ActionServer, made, first)

    def action_client(self, action_type: str, action: str, **options: Unpack[ServiceOptions]) -> ActionClient:
        """Create an action client. The arguments and the exceptions are those of `action_server`."""
        first, network = len(self._closing), self._services.network
        endpoints = ClientEndpoints(*self._endpoints(action_type, action, options, serves=False))
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
            remedy = "wire serverHandle from a ROS2ActionServerGoal"
            raise ContextError(f"no action server has the handle {handle}", handle, remedy)
        return servers[-1]

    def _endpoints(self, action_type: str, action: str, options: ServiceOptions, *, serves: bool) -> list[Any]:
        """Create the endpoints of an action, in the order of the fields of `ServerEndpoints` and of `ClientEndpoints`.

        Args:
            action_type: ROS 2 name of the action type.
            action: name of the action in its namespace.
            options: options of the services.
            serves: whether the endpoints are those of a server.
        """
        names.full_topic(options.get("namespace", ""), action, "action name")
        parts, network = goals.parts(names.strip(action), action_type), self._services.network
        open_service = self.service_server if serves else self.service_client
        roles = [parts[role] for role in ("send_goal", "cancel_goal", "get_result")]
        made: list[Any] = [open_service(part.message_type, part.name, **options) for part in roles]
        feedback = goals.FEEDBACK_QOS if serves else goals.FEEDBACK_READER_QOS
        for part, quality in ((parts["feedback"], feedback), (parts["status"], goals.STATUS_QOS)):
            chosen: dict[str, Any] = {"collects_namespace": False, **options, "qos_profile": qos_json(quality)}
            claim = self._claim("publish" if serves else "subscribe", part.message_type, part.name, **chosen)
            made.append(self._own(network.publisher(claim)) if serves else self._own(network.subscription(claim)))
        return made

    def _hold(self, kind: type[A], made: A, first: int) -> A:
        """Register the node as a holder of the action, and return the action.

        If an action with the same endpoints exists, because the graph is being reloaded, this action is returned instead of
        `made`. The node releases the action before it destroys the endpoints, whose entries in `_closing` begin at index `first`.
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
