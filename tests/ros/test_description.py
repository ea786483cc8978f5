"""The description of a running ROS 2 system: from its latched topic, and from a node's parameter."""

from __future__ import annotations

import contextlib
import threading

import pytest

from graphengine.format.errors import TopicError, TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.description import from_node, from_topic
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.rcl.rcl import RclTransport, discovery
from tests.ros import needs
from tests.ros.conftest import OpenDds

PARAMETERS = "rcl_interfaces/srv/GetParameters"
STRING = "std_msgs/msg/String"
TEXT = '<robot name="é"/>'


def encoded(text: str) -> bytes:
    return messages.encode(messages.message_class(STRING)(data=text))


def test_an_earlier_latched_message_is_read() -> None:
    transport = MemoryTransport()
    transport.writer("/robot_description", STRING, LATCHED).write(encoded(TEXT))
    assert from_topic(transport, "robot_description", timeout=0.1) == TEXT


def test_a_later_message_is_waited_for() -> None:
    transport = MemoryTransport()
    writer = transport.writer("/a/robot_description", STRING, LATCHED)
    later = threading.Timer(0.05, writer.write, [encoded(TEXT)])
    later.start()
    assert from_topic(transport, "/a/robot_description", timeout=60) == TEXT
    later.join()


def test_the_error_about_a_silent_topic_suggests_robot_state_publisher() -> None:
    transport = MemoryTransport()
    transport.writer("/robot_description", STRING, QoS()).write(encoded(TEXT))  # not latched: gone
    with pytest.raises(TransportError) as caught:
        from_topic(transport, "/robot_description", timeout=0.01)
    first, second, third = str(caught.value).splitlines()
    assert first == "no message arrived on /robot_description within 0.01 s"
    assert second == "listened over memory: nothing leaves this process"
    assert "robot_state_publisher" in third


def test_illegal_names_are_reported() -> None:
    with pytest.raises(TopicError, match="topic name '/a b' has ' '"):
        from_topic(MemoryTransport(), "a b", timeout=0.01)
    for node, told in (("a b", "node name 'a b'"), ("/a-b/c", "namespace '/a-b'"), ("/", "node name '' .* is empty")):
        with pytest.raises(TopicError, match=told):
            from_node(MemoryTransport(), node, timeout=0.01)


def parameters(transport: MemoryTransport | DdsTransport, node: str, *texts: str) -> None:
    """Answer as a node that has a parameter with a text, or none."""

    def answer(request_id: bytes, data: bytes) -> None:
        assert messages.decode(data, f"{PARAMETERS}_Request").names == ["robot_description"]
        response = DEFINITIONS.initial(f"{PARAMETERS}_Response")
        for text in texts:
            value = DEFINITIONS.initial("rcl_interfaces/msg/ParameterValue")
            value.type, value.string_value = 4, text
            response.values.append(value)
        server.answer(request_id, messages.encode(response))

    server = transport.server(f"{node}/get_parameters", PARAMETERS, QoS(), answer)


def test_the_parameter_of_a_node_is_read_over_dds(dds: OpenDds) -> None:
    node, client = dds("publisher"), dds("client")
    parameters(node, "/publisher", TEXT)
    parameters(node, "/a/other")
    assert from_node(client, "publisher", timeout=60) == TEXT
    with pytest.raises(TransportError, match="node /a/other has no string parameter 'robot_description'"):
        from_node(client, "/a/other", timeout=60)
    with pytest.raises(TransportError, match="no node /absent answers") as caught:
        from_node(client, "/absent", timeout=0.1)
    assert str(caught.value).endswith("nodes: /publisher")


def test_a_call_without_a_response_is_reported() -> None:
    transport = MemoryTransport()
    transport.server("/busy/get_parameters", PARAMETERS, QoS(), lambda request_id, data: None)
    with pytest.raises(TransportError, match=r"node /busy does not answer within 0.01 s"):
        from_node(transport, "/busy", timeout=0.01)


@pytest.mark.ros
@pytest.mark.parametrize("own", ["rclpy", pytest.param("dds", marks=pytest.mark.ros(needs.cyclone()))])
def test_the_parameter_of_a_node_is_read(domain: Domain, own: str) -> None:
    import rclpy
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from rclpy.node import Node

    context = rclpy.Context()
    with discovery(domain):
        context.init(args=[], domain_id=domain.id)

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            executor.spin()

    executor = SingleThreadedExecutor(context=context)
    for namespace, name, value in (
        ("/", "publisher", TEXT),
        ("/dd100_0000", "publisher_", f"{TEXT} "),
        ("/", "other", None),
        ("/", "number", 5),
    ):
        node = Node(name, namespace=namespace, context=context)
        if value is not None:
            node.declare_parameter("robot_description", value)
        executor.add_node(node)
    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    client = (RclTransport if own == "rclpy" else DdsTransport)(JoinOptions(domain, "client"))
    assert from_node(client, "publisher", timeout=60) == TEXT
    assert from_node(client, "/dd100_0000/publisher_", timeout=60) == f"{TEXT} "
    for name in ("/other", "/number"):
        with pytest.raises(TransportError, match=f"node {name} has no string parameter 'robot_description'"):
            from_node(client, name, timeout=60)
    with pytest.raises(TransportError, match="no node /absent answers") as caught:
        from_node(client, "/absent", timeout=0.1)
    assert str(caught.value).endswith("nodes: /dd100_0000/publisher_, /number, /other, /publisher")
    client.close()
    context.try_shutdown()
    thread.join(20)


@pytest.mark.ros
def test_a_missing_node_is_reported(domain: Domain) -> None:
    import rclpy
    from rclpy.node import Node

    context = rclpy.Context()
    with discovery(domain):
        context.init(args=[], domain_id=domain.id)
    busy = Node("busy", context=context)  # which nobody spins
    client = RclTransport(JoinOptions(domain, "client"))
    with pytest.raises(TransportError, match=r"node /busy does not answer within 1 s"):
        from_node(client, "/busy", timeout=1)
    client.close()
    busy.destroy_node()
    context.try_shutdown()
