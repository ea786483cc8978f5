"""Reads the robot description of a running ROS 2 system: from its latched topic, or from a parameter of a node."""

from __future__ import annotations

from graphengine.format.errors import TransportError
from graphengine.format.wording import listing
from graphengine.messages import messages, names
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.qos import LATCHED
from graphengine.ros.cli_subscription import MessageQueue
from graphengine.ros.network_graph import split_name
from graphengine.ros.service_caller import ServiceCaller
from graphengine.ros.transport import Transport, discover

PARAMETER = "robot_description"
_STRING = "std_msgs/msg/String"
_GET = "rcl_interfaces/srv/GetParameters"
_TEXT = 4
"""Constant PARAMETER_STRING of rcl_interfaces/msg/ParameterType."""
_WAITING = 100
"""Capacity of the message queue, of which only the oldest message is used."""


def from_topic(transport: Transport, topic: str, timeout: float) -> str:
    """Return the text of the first message on a topic, which robot_state_publisher latches for late subscribers.

    Args:
        transport: open transport on the domain of the system.
        topic: name of the topic; a relative name is in the root namespace.
        timeout: longest wait, s.

    Raises:
        TopicError: the topic's name is not legal in ROS 2.
        TransportError: no message arrives in time, or it cannot be decoded.
    """
    topic = f"/{topic.removeprefix('/')}"
    names.check_topic(topic)
    inbox = MessageQueue(_WAITING)
    reader = transport.reader(topic, _STRING, LATCHED, inbox.deliver)
    try:
        arrival = inbox.take(timeout)
        if arrival is None:
            what = f"no message arrived on {topic} within {timeout:g} s\nlistened over {transport.description}"
            hint = "is a robot_state_publisher running in this domain? its topic must be latched (transient local)"
            raise TransportError(f"{what}\n{hint}")
    finally:
        reader.close()
    return str(messages.decode(arrival.data, _STRING).data)


def from_node(transport: Transport, node: str, timeout: float) -> str:
    """Return the parameter `robot_description` of a node, from its service GetParameters.

    Args:
        transport: open transport on the domain of the node.
        node: full name, such as `/robot_state_publisher`.
        timeout: longest wait for the service, s, and longest wait for the response, s.

    Raises:
        TopicError: the node's name is not legal in ROS 2.
        TransportError: the node does not exist, is unreachable, or does not have the parameter as a string.
    """
    node = f"/{node.removeprefix('/')}"
    namespace, name = split_name(node)
    names.check_namespace(namespace, given=node)
    names.check_node_name(name, given=node)
    service = f"{node}/get_parameters"
    caller = ServiceCaller(transport, service, _GET)
    try:
        if not caller.becomes_ready(timeout):
            raise TransportError(_absent(transport, node, service, timeout))
        request = DEFINITIONS.initial(f"{_GET}_Request")
        request.names = [PARAMETER]
        values = caller.call(request).result(timeout).values
    except TimeoutError:
        raise TransportError(f"node {node} does not answer within {timeout:g} s") from None
    finally:
        caller.close()
    if not values or values[0].type != _TEXT:
        raise TransportError(f"node {node} has no string parameter {PARAMETER!r}")
    return str(values[0].string_value)


def _absent(transport: Transport, node: str, service: str, timeout: float) -> str:
    """Return the error message for an unavailable service: the warning about incompatible peers, else a list of known nodes."""
    foreign = transport.foreign_services
    if service in foreign:
        return foreign[service]
    others = {end.full_node for end in discover(transport, names=True).endpoints} - {transport.node, ""}
    return f"no node {node} answers within {timeout:g} s\n{listing(sorted(others), 'nodes')}"
