"""`graphrun node`: nodes of a live network, in the form of ros2cli."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import TypeAlias

import pytest

from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.action_graph import FIBONACCI
from tests.action_peer import ActionServerPeer
from tests.cli.harness import Graphrun

STRING, SET_BOOL = "std_msgs/msg/String", "std_srvs/srv/SetBool"

Join: TypeAlias = Callable[..., DdsTransport]


@pytest.fixture
def join(domain_id: int) -> Iterator[Join]:
    """Joins the domain as a node."""
    with contextlib.ExitStack() as stack:

        def join(name: str, namespace: str = "/") -> DdsTransport:
            transport = DdsTransport(JoinOptions(Domain(domain_id, "OFF"), name, namespace))
            return stack.enter_context(contextlib.closing(transport))

        yield join


@pytest.fixture
def node(graphrun: Graphrun) -> Graphrun:
    """`graphrun node` in this process."""
    return lambda verb, *arguments, **ended: graphrun("node", verb, *arguments, "--transport", "dds", **ended)


def test_list_names_nodes_in_order_and_hides_those_of_tools(node: Graphrun, join: Join) -> None:
    for name, namespace in (("talker", "/robots"), ("listener", "/"), ("_tool", "/robots")):
        join(name, namespace)
    assert node("list", code=0, err="").out == "/listener\n/robots/talker\n"
    assert node("list", "-c", code=0, err="").out == "2\n"
    assert node("list", "-a", code=0, err="").out == "/listener\n/robots/_tool\n/robots/talker\n"


def test_nodes_of_one_name_are_listed_with_a_warning(node: Graphrun, join: Join) -> None:
    join("talker").writer("/a", STRING, QoS())
    join("talker").writer("/b", STRING, QoS())
    result = node("list", code=0)
    assert (result.out, "have the same name" in result.err) == ("/talker\n/talker\n", True)
    result = node("info", "/talker", code=0)
    assert {"    /a: std_msgs/msg/String", "    /b: std_msgs/msg/String"} < set(result.lines)
    assert "2 nodes have the name '/talker'" in result.err


def test_an_empty_list_names_the_searched_domain(node: Graphrun, domain_id: int) -> None:
    assert node("list", code=0, out="").err.startswith("no nodes on domain ")


def test_info_has_topics_services_and_actions(node: Graphrun, join: Join) -> None:
    peer = join("peer", "/robots")
    peer.reader("/chatter", STRING, QoS(), lambda data: None)
    peer.server("/light", SET_BOOL, QoS(), lambda request_id, data: None)
    peer.client("/ask", SET_BOOL, QoS(), lambda number, data: None)
    ActionServerPeer(peer, "/fibonacci", FIBONACCI)
    assert node("info", "/robots/peer", code=0, err="").out == (
        "/robots/peer\n"
        "  Subscribers:\n    /chatter: std_msgs/msg/String\n"
        "  Publishers:\n    /parameter_events: rcl_interfaces/msg/ParameterEvent\n    /rosout: rcl_interfaces/msg/Log\n"
        f"  Service Servers:\n    /light: {SET_BOOL}\n"
        f"  Service Clients:\n    /ask: {SET_BOOL}\n"
        f"  Action Servers:\n    /fibonacci: {FIBONACCI}\n"
        "  Action Clients:\n\n"
    )
    hidden = node("info", "robots/peer", "--include-hidden", code=0, err="").lines
    assert f"    /fibonacci/_action/send_goal: {FIBONACCI}_SendGoal" in hidden


def test_info_of_an_unknown_node_suggests_another(node: Graphrun, join: Join) -> None:
    join("talker")
    assert "unknown node '/taker'\ndid you mean '/talker'?" in node("info", "/taker", code=1, out="").err
