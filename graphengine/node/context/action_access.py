"""The part of a context that opens action servers and clients, and closes them with the node."""

from __future__ import annotations

from functools import partial
from typing import Unpack

from graphengine.messages import goals, names
from graphengine.messages.actions import ActionServer, ServerEndpoints
from graphengine.messages.endpoints import Publisher, ServiceServer
from graphengine.node.clock import Clock
from graphengine.node.context.endpoint_access import OwnedEndpoints, ServiceOptions


class OwnedActions(OwnedEndpoints):
    """The actions of a node, each of which consists of services and topics of the node."""

    clock: Clock

    def action_server(self, action_type: str, action: str, **options: Unpack[ServiceOptions]) -> ActionServer:
        """Open an action server. While a changed graph replaces the running one, it takes over the open server with its goals.

        Args:
            action_type: ROS 2 name of the action type, such as `control_msgs/action/FollowJointTrajectory`.
            action: name of the action in its namespace; leading and trailing non-alphanumerics are dropped.
            options: see `ServiceOptions`; the QoS profile is that of the services.

        Raises:
            TopicError: the name, the namespace or the QoS profile is not valid.
        """
        names.full_topic(options.get("namespace", ""), action, "action name")
        opened, parts = len(self._closing), goals.parts(names.strip(action), action_type)

        def service(part: str) -> ServiceServer:
            return self.service_server(parts[part].message_type, parts[part].name, **options)

        send_goal = service("send_goal")
        full, context = goals.action_of(send_goal.service), options.get("ros_context", 0)

        def topic(part: str, latched: bool) -> Publisher:
            name, kind = goals.parts(full, action_type)[part]
            claim = self._claim("publish", kind, name, collects_namespace=False, latched=latched, ros_context=context)
            publisher = self._services.network.publisher(claim)
            self._closing.append(publisher.close)
            return publisher

        endpoints = ServerEndpoints(
            send_goal, service("cancel_goal"), service("get_result"), topic("feedback", False), topic("status", True)
        )
        servers = self._services.action_servers
        server = next((one for one in servers if one.endpoints.same(endpoints)), None)
        if server is None:
            clock, definitions = self.clock, self._services.network.definitions
            server = ActionServer(full, action_type, endpoints, lambda: clock.time, definitions)
            servers.append(server)
        else:
            server.holders += 1
        self._closing.insert(opened, partial(self._close_server, server))
        return server

    def _close_server(self, server: ActionServer) -> None:
        server.close()
        if not server.holders:
            self._services.action_servers.remove(server)
