"""Limits of the room ros."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros import endpoint_faults
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.domain import Domain
from graphengine.ros.foxglove import open_server, publish_gate
from graphengine.ros.foxglove.foxglove_layout import foxglove_layout
from graphengine.ros.foxglove.foxglove_server import ServedEnd
from graphengine.ros.network import LiveNetwork
from graphengine.ros.network_graph import Endpoint
from graphengine.ros.service_caller import ServiceCaller
from graphengine.ros.tf_tree import FrameTree
from graphengine.ros.topic_endpoints import LiveSubscription
from graphengine.ros.transports.calls import Calls
from graphengine.ros.transports.dds import dds_services
from graphengine.ros.transports.dds.dds_services import DdsServer
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.limits.table import accepts, limit

KEEP_ALL = QoS(history="keepAll")


@limit("ros.domain.MAX_DOMAIN_ID")
def _(number: int) -> bool:
    return accepts(lambda: Domain(number, "OFF"), TransportError)


@limit("ros.domain.MAX_DOMAIN_ID")
def _(number: int) -> bool:
    return accepts(lambda: Domain.from_environment({"ROS_DOMAIN_ID": str(number)}), TransportError)


@limit("ros.network_graph.MAX_NAME")
def _(letters: int) -> bool:
    topic = "/".ljust(letters, "a")
    return Endpoint(b"", "publish", topic, "std_msgs/msg/String", QoS()).topic == topic


@limit("ros.tf_tree.MAX_EDGES", at=3)
def _(edges: int) -> bool:
    tree = FrameTree()
    transform = messages.Transform(messages.Vector3(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    stamped = [
        messages.TransformStamped(messages.Header(messages.Time(0, 0), "map"), f"f{number}", transform)
        for number in range(edges)
    ]
    tree.add(messages.TFMessage(stamped), static=False, source=b"")
    return len(tree.edges) == edges


@limit("ros.endpoint_faults.MOST", at=3)
def _(faults: int) -> bool:
    finder = endpoint_faults.Finder(MemoryTransport(), DEFINITIONS, 0)
    found = list(finder._new("/a", [(f"{number}", "") for number in range(faults)], endpoint_faults.MOST))
    return not any("more endpoints" in text for text in found)


@limit("ros.transports.calls.MAX_OPEN", at=3)
def _(calls: int) -> bool:
    given_up: list[Any] = []
    table = Calls(given_up.append)
    for _ in range(calls):
        table.begin()
    return not given_up


@limit("ros.transports.calls.MAX_OPEN", at=3)
def _(calls: int) -> bool:
    caller = ServiceCaller(MemoryTransport(), "/a", "std_srvs/srv/Trigger")
    with closing(caller):
        request = DEFINITIONS.initial("std_srvs/srv/Trigger_Request")
        made = [caller.call(request) for _ in range(calls)]
        return not any(call.done() for call in made)


@limit("ros.action_caller.MAX_CALLS", at=3)
def _(goals: int) -> bool:
    caller = ActionCaller(MemoryTransport(), "/a", "example_interfaces/action/Fibonacci", DEFINITIONS)
    with closing(caller):
        goal = DEFINITIONS.initial("example_interfaces/action/Fibonacci_Goal")
        for _ in range(goals):
            caller.send(goal)
        return len(caller._calls) == goals


@limit("ros.topic_endpoints.MAX_KEPT", at=3)
def _(received: int) -> bool:
    network = LiveNetwork(lambda _: MemoryTransport(), 0, print)
    with closing(network):
        claim = EndpointClaim("/node", "g", "/a", "std_msgs/msg/String", "subscribe", KEEP_ALL)
        subscription = network.subscription(claim)
        assert isinstance(subscription, LiveSubscription)
        for _ in range(received):
            subscription.deliver(messages.encode(messages.String("a")))
        return len(subscription._arrived) == received


@limit("ros.foxglove.foxglove_server.MAX_NAMES", at=20)
def _(letters: int) -> bool:
    with closing(open_server(("127.0.0.1", 0), "test", DEFINITIONS, publish=True)) as server:
        channel = {"id": 1, "topic": "/".ljust(letters - 1, "a"), "encoding": "cdr", "schemaName": "b"}
        server.announce(1, {"op": "advertise", "channels": [channel]})
        return len(server._published) == 1


@limit("ros.foxglove.publish_gate.MAX_MESSAGE", at=100)
def _(size: int) -> bool:
    return _is_taken(b"\1".ljust(size, b"\0"))


@limit("ros.foxglove.publish_gate.MAX_TEXT", at=100)
def _(size: int) -> bool:
    return _is_taken("{}".ljust(size))


def _is_taken(message: str | bytes) -> bool:
    """Return whether a Foxglove server reads this text: it then answers the invalid channel that follows with a warning."""
    with (
        closing(open_server(("127.0.0.1", 0), "test", DEFINITIONS, publish=True)) as server,
        connect(server.url, subprotocols=[publish_gate.SUBPROTOCOL]) as client,
    ):
        try:
            client.send(message)
            client.send('{"op": "advertise", "channels": [0]}')
            while '"status"' not in client.recv(timeout=10):
                pass
        except ConnectionClosed:
            return False
        return True


@limit("ros.foxglove.foxglove_server.MAX_KEPT", at=3)
def _(latched: int) -> bool:
    end = ServedEnd("/a", "std_msgs/msg/String", QoS(history="keepAll", durability="transientLocal"))
    end.kept.extend([b""] * latched)
    return len(end.kept) == latched


@limit("ros.transports.dds.dds_services._MAX_HELD", at=3)
def _(responses: int) -> bool:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dds_services._DdsService, "__init__", lambda *_: None)
        server = DdsServer("/a", None, None, None)  # type: ignore[arg-type]
    server._held.extend([(0, b"")] * responses)
    return len(server._held) == responses


@limit("ros.foxglove.foxglove_layout.MOST")
def _(cameras: int) -> bool:
    claims = [EndpointClaim("/n", "g", f"/{n}", "sensor_msgs/msg/Image", "publish", QoS()) for n in range(cameras)]
    return len(foxglove_layout(claims)["configById"]) == 1 + cameras  # and the 3D view
