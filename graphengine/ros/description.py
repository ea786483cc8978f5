"""The robot description of a running ROS 2 system: from its latched topic, or from a parameter of a node."""

from __future__ import annotations

import threading
from typing import Any

from graphengine.diagnostics import TransportError, listing
from graphengine.ros import messages, names
from graphengine.ros.domain import Domain
from graphengine.ros.qos import LATCHED
from graphengine.ros.rcl import discovery, import_error
from graphengine.ros.transport import Transport

PARAMETER = "robot_description"
_STRING = "std_msgs/msg/String"
_CLIENT = "graphrun_import_urdf"


def from_topic(transport: Transport, topic: str, timeout: float) -> str:
    """The text of the first message on a topic, which robot_state_publisher keeps for those who come late.

    Args:
        transport: open, on the domain to listen on.
        topic: its name; a relative one lies in the root namespace.
        timeout: s.

    Raises:
        TopicError: ROS 2 would refuse the topic's name.
        TransportError: nothing arrives in time, or what arrives is no text.
    """
    topic = f"/{topic.removeprefix('/')}"
    names.check_topic(topic)
    arrived: list[bytes] = []
    heard = threading.Event()

    def deliver(data: bytes) -> None:
        arrived.append(data)
        heard.set()

    reader = transport.reader(topic, _STRING, LATCHED, deliver)
    try:
        if not heard.wait(timeout):
            raise TransportError(
                f"nothing arrived on {topic} within {timeout:g} s\nlistened by {transport.description}\n"
                "is a robot_state_publisher running in this domain? its topic must be latched (transient local)"
            )
    finally:
        reader.close()
    return str(messages.decode(arrived[0], _STRING).data)


def from_node(node: str, domain: Domain, timeout: float) -> str:
    """The parameter `robot_description` of a node, by its service GetParameters.

    Args:
        node: its name with its namespace, such as `/robot_state_publisher`.
        domain: that it is in.
        timeout: s, for finding it and again for its answer.

    Raises:
        TopicError: ROS 2 would refuse the name.
        TransportError: rclpy is not there, or no such node, or it has no such parameter.
    """
    node = f"/{node.removeprefix('/')}"
    namespace, _, name = node.rpartition("/")
    names.check_namespace(namespace or "/", given=node)
    names.check_node_name(name, given=node)
    missing = import_error()
    if missing:
        remedy = "source ROS 2 first, or use --topic, which needs none"
        raise TransportError(f"only rclpy reads parameters of nodes, and it cannot be used: {missing}\n{remedy}")
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node

    context = rclpy.Context()
    with discovery(domain):
        context.init(args=[], domain_id=domain.id)
    try:
        client = Node(_CLIENT, context=context, start_parameter_services=False)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(client)
        try:
            return _parameter(client, executor, node, timeout)
        finally:
            client.destroy_node()
    finally:
        context.try_shutdown()


def _parameter(client: Any, executor: Any, node: str, timeout: float) -> str:
    from rcl_interfaces.msg import ParameterType
    from rcl_interfaces.srv import GetParameters

    service = client.create_client(GetParameters, f"{node}/get_parameters")
    if not service.wait_for_service(timeout_sec=timeout):
        there = listing(sorted(_nodes(client) - {f"/{_CLIENT}"}), "nodes")
        raise TransportError(f"no node {node} answers within {timeout:g} s\n{there}")
    asked = service.call_async(GetParameters.Request(names=[PARAMETER]))
    executor.spin_until_future_complete(asked, timeout_sec=timeout)
    if not asked.done():
        raise TransportError(f"node {node} does not answer within {timeout:g} s")
    values = asked.result().values
    if not values or values[0].type != ParameterType.PARAMETER_STRING:
        raise TransportError(f"node {node} has no parameter {PARAMETER!r} with text")
    return str(values[0].string_value)


def _nodes(client: Any) -> set[str]:
    """Names of the nodes that can be seen."""
    return {f"{namespace.rstrip('/')}/{name}" for name, namespace in client.get_node_names_and_namespaces()}
