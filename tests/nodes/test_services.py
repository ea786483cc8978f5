"""Service nodes: ports of any service, requests one after the other, calls and their answers."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import ContextError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.node import Node
from graphengine.node.node_class import grown
from graphengine.nodes.ros2.services import OgnROS2ServiceClient as Client
from graphengine.nodes.ros2.services import OgnROS2ServiceServerRequest as Request
from graphengine.nodes.ros2.services import OgnROS2ServiceServerResponse as Response
from graphengine.ros.service_endpoints import MAX_OPEN
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene.loaded_scene import Options
from graphengine.testing import RecordingContext, check_node
from tests.nodes.harness import Player, names, ready, write
from tests.service_graph import ANSWER, ASK, BOTH, SERVER, SET_BOOL, extended


def ports(cls: type[Node], service_type: str) -> dict[str, str]:
    made = grown(cls, names(service_type), DEFINITIONS)
    own = {port.field for port in cls.fields.values()}
    return {f"{port.side}:{port.name}": str(port.type) for port in made.fields.values() if port.field not in own}


def of(cls: type[Node], context: RecordingContext, /, **inputs: Any) -> Any:
    """A node of SetBool, set up."""
    made = grown(cls, names(SET_BOOL), DEFINITIONS)
    return ready(made, context, message_package="std_srvs", message_name="SetBool", **inputs)


class Peer:
    """A client that another program has."""

    def __init__(self, transport: MemoryTransport, service: str = "/light") -> None:
        self.answers: list[tuple[int, Any]] = []
        self.client = transport.client(service, SET_BOOL, QoS(), self._take)

    def ask(self, *wanted: bool) -> None:
        for data in wanted:
            self.client.call(messages.encode(ASK(data)))

    def _take(self, number: int, data: bytes) -> None:
        answer = messages.decode(data, f"{SET_BOOL}_Response")
        self.answers.append((number, (answer.success, answer.message)))


class PeerServer:
    """A server that another program has."""

    def __init__(self, transport: MemoryTransport, service: str = "/service_name") -> None:
        self.requests: list[tuple[bytes, bool]] = []
        self.server = transport.server(service, SET_BOOL, QoS(), self._take)

    def answer(self, text: str, index: int = 0) -> None:
        request_id, data = self.requests.pop(index)
        self.server.answer(request_id, messages.encode(ANSWER(data, text)))

    def _take(self, request_id: bytes, data: bytes) -> None:
        self.requests.append((request_id, messages.decode(data, f"{SET_BOOL}_Request").data))


# Ports


def test_a_client_has_inputs_for_the_request_and_outputs_for_the_response() -> None:
    assert ports(Client, SET_BOOL) == {
        "inputs:Request:data": "bool",
        "outputs:Response:success": "bool",
        "outputs:Response:message": "token",
    }


def test_a_server_is_a_pair_of_nodes_for_requests_and_responses() -> None:
    assert ports(Request, SET_BOOL) == {"outputs:Request:data": "bool"}
    assert ports(Response, SET_BOOL) == {"inputs:Response:success": "bool", "inputs:Response:message": "token"}


# isaacsim.ros2.nodes/python/tests/test_service.py, SERVICE_FIELD_TYPE_CASES
def test_nested_fields_have_isaac_sims_names_and_types() -> None:
    found = ports(Request, "nav_msgs/srv/GetPlan")
    expected = {
        "tolerance": "float",
        "start:header:stamp:sec": "int",
        "start:header:stamp:nanosec": "uint",
        "start:header:frame_id": "token",
        "start:pose:position:x": "double",
    }
    assert {name: found[f"outputs:Request:{name}"] for name in expected} == expected
    assert ports(Request, "rcl_interfaces/srv/ListParameters")["outputs:Request:depth"] == "uint64"


def test_a_service_without_fields_adds_no_ports() -> None:
    assert ports(Client, "std_srvs/srv/Empty") == {}


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"messageName": "SetBol"}, "no message type 'std_srvs/srv/SetBol'"),
        ({"messageName": ""}, "the inputs name no message type"),
        (
            {"messagePackage": "std_msgs", "messageSubfolder": "msg", "messageName": "Bool"},
            "std_msgs/msg/Bool is not a service type",
        ),
    ],
)
def test_a_type_that_is_not_a_service_is_an_error(given: dict[str, str], fault: str) -> None:
    with pytest.raises(ContextError, match=fault):
        grown(Client, {**names(SET_BOOL), **given}, DEFINITIONS)


def test_a_service_of_a_users_type_is_served(play: Player) -> None:
    write(play.folder, {"my_msgs/srv/Echo.srv": "int64 a\n---\nint64 b\n"})
    text = """
nodes:
  Tick: OnPlaybackTick
  Client:
    type: ROS2ServiceClient
    inputs: {messagePackage: my_msgs, messageName: Echo, "Request:a": 11}
  Server: {type: ROS2ServiceServerRequest, inputs: {messagePackage: my_msgs, messageName: Echo}}
  Answer: {type: ROS2ServiceServerResponse, inputs: {messagePackage: my_msgs, messageName: Echo}}
connections:
  - Tick.tick -> Client.execIn
  - Tick.tick -> Server.execIn
  - Server.onReceived -> Answer.onReceived
  - Server.serverHandle -> Answer.serverHandle
  - Server.Request:a -> Answer.Response:b
"""
    playing = play.graph(text, options=Options(message_paths=[play.folder])).tick(3)
    assert playing.node("Client").response__b == 11


# The server


class Offered:
    """A server of two nodes alone, and a client that another program has."""

    def __init__(self, **answer: Any) -> None:
        self.context = RecordingContext()
        self.request = of(Request, self.context, service_name="light")
        self.response = of(Response, self.context, server_handle=self.request.server_handle, **answer)
        self.peer = Peer(self.context.transport)

    def asked(self, *wanted: bool) -> list[bool]:
        """Requests that come, and what the node puts out in the tick that follows."""
        self.peer.ask(*wanted)
        self.context.tick()
        return [self.request.request__data for _ in self.request.compute()]

    def answers(self) -> list[tuple[int, Any]]:
        """What the peer has been answered when the tick ends."""
        self.context.services.network.flush()
        return self.peer.answers


def test_a_request_is_output_and_its_response_sent_at_the_end_of_the_tick() -> None:
    server = Offered(response__success=True, response__message="on")
    assert server.asked(True) == [True]
    assert server.response.compute() == server.response.exec_out
    assert server.peer.answers == []
    assert server.answers() == [(1, (True, "on"))]


def test_the_requests_of_a_tick_get_their_responses_in_order(play: Player) -> None:
    playing = play.graph(SERVER)
    peer = Peer(playing.transport)
    peer.ask(True, False, True)
    playing.tick()
    assert peer.answers == [(1, (True, "done")), (2, (False, "done")), (3, (True, "done"))]


def test_requests_wait_while_the_node_is_not_executed() -> None:
    server = Offered()
    server.peer.ask(True)
    server.context.tick()
    assert server.asked(False) == [True, False]
    assert list(server.request.compute()) == []


def test_a_request_without_response_is_dropped_at_the_next_request_with_a_warning() -> None:
    server = Offered()
    server.asked(True, False)
    assert server.response.compute() == server.response.exec_out
    assert [number for number, _ in server.answers()] == [2]
    assert server.context.logged == [("warning", "/light: the next request came before a response was sent")]


def test_a_request_is_answered_once() -> None:
    server = Offered()
    server.asked(True)
    assert [server.response.compute(), server.response.compute()] == [server.response.exec_out, None]
    assert len(server.answers()) == 1
    assert server.context.logged == [("warning", "/light: there is no request to answer")]


def test_a_request_from_before_a_stop_is_not_answered() -> None:
    server = Offered()
    server.asked(True)
    server.context.stop(server.request, server.response)
    assert server.response.compute() is None
    assert server.answers() == []


def test_a_server_answers_again_after_stop_and_play(play: Player) -> None:
    playing = play.graph(SERVER)
    peer = Peer(playing.transport)
    for wanted in (True, False):
        peer.ask(wanted)
        playing.tick()
        playing.session.stop()
    assert [success for _, (success, _) in peer.answers] == [True, False]


def test_requests_beyond_the_queue_are_refused_and_reported() -> None:
    server = Offered()
    assert len(server.asked(*[True] * (MAX_OPEN + 5))) == MAX_OPEN
    text = f"/light: more than {MAX_OPEN} requests are waiting for the graph; further requests are not answered"
    assert [said for said in server.context.logged if said[0] == "network"] == [("network", text)]


def test_a_handle_without_a_server_is_an_error_that_says_where_to_get_a_handle(context: RecordingContext) -> None:
    with pytest.raises(ContextError, match="no service server has the handle 7") as caught:
        of(Response, context, server_handle=7)
    assert caught.value.help == ("wire serverHandle from a ROS2ServiceServerRequest",)


def test_both_nodes_of_a_server_name_the_same_service(play: Player) -> None:
    text = SERVER.replace(
        'inputs: {messagePackage: std_srvs, messageName: SetBool, "Response:message": done}',
        "inputs: {messagePackage: std_srvs, messageName: Trigger}",
    ).replace("  - Server.Request:data -> Answer.Response:success\n", "")
    with pytest.raises(
        CheckError,
        match="Answer: the node is for std_srvs/srv/Trigger, but the service /light has type std_srvs/srv/SetBool",
    ):
        play.graph(text)


def test_a_response_needs_a_handle(play: Player) -> None:
    with pytest.raises(CheckError, match="serverHandle"):
        play.graph(SERVER.replace("  - Server.serverHandle -> Answer.serverHandle\n", ""))


def test_a_service_renamed_during_the_run_answers_only_by_its_new_name(play: Player) -> None:
    playing = play.graph(SERVER)
    old, new = Peer(playing.transport), Peer(playing.transport, "/lamp")
    playing.tick()
    playing.set("Server", "service_name", "lamp")
    old.ask(True)
    new.ask(True)
    playing.tick()
    assert (old.client.ready, new.client.ready) == (False, True)
    assert (len(old.answers), len(new.answers)) == (0, 1)
    assert [claim.topic for claim in playing.session.services.claims] == ["/lamp"]


# Names


@pytest.mark.parametrize(
    ("inputs", "name"),
    [
        ({}, "/service_name"),
        ({"service_name": "a/b"}, "/a/b"),
        ({"service_name": "light", "node_namespace": "robot"}, "/robot/light"),
    ],
)
def test_a_service_has_the_namespace_of_the_node_and_not_of_its_prims(inputs: dict[str, str], name: str) -> None:
    context = RecordingContext("/dd100/graph/node")
    context.world.stage.add("/dd100", "robot", namespace="dd100_0000")
    assert of(Request, context, **inputs).server.service == name
    assert of(Client, context, **inputs).client.service == name


def test_a_name_that_ros_refuses_is_reported_at_its_place(play: Player) -> None:
    with pytest.raises(CheckError, match=r"graph.yaml:7:27: error G304: Server: service name '/1light'"):
        play.graph(SERVER.replace("serviceName: light", "serviceName: 1light"))


def test_a_second_server_of_one_service_is_an_error(play: Player) -> None:
    inputs = "{serviceName: /light, messagePackage: std_srvs, messageName: SetBool}"
    second = f"  Second: {{type: ROS2ServiceServerRequest, inputs: {inputs}}}\n"
    with pytest.raises(CheckError, match="error G309: the service /light has a server here and another in"):
        play.graph(extended(SERVER, second, "Tick.tick -> Second.execIn"))


def test_a_server_with_a_context_and_one_without_are_in_the_same_domain(play: Player) -> None:
    inputs = "{serviceName: /light, messagePackage: std_srvs, messageName: SetBool}"
    second = f"  Context: ROS2Context\n  Second: {{type: ROS2ServiceServerRequest, inputs: {inputs}}}\n"
    wires = ("Tick.tick -> Second.execIn", "Context.context -> Second.context")
    with pytest.raises(CheckError, match="error G309: the service /light has a server here and another in"):
        play.graph(extended(SERVER, second, *wires))
    other = second.replace("Context: ROS2Context", "Context: {type: ROS2Context, inputs: {domain_id: 7}}")
    play.graph(extended(SERVER, other, *wires))


def test_a_topic_may_have_the_name_of_a_service(play: Player) -> None:
    clock = "  Clock: {type: ROS2PublishClock, inputs: {topicName: light}}\n"
    playing = play.graph(extended(SERVER, clock, "Tick.tick -> Clock.execIn"))
    assert {claim.topic for claim in playing.session.services.claims} == {"/light"}


def test_a_client_of_another_type_than_the_server_is_an_error(play: Player) -> None:
    client = "  Client: {type: ROS2ServiceClient, inputs: {serviceName: light, messagePackage: std_srvs, messageName: Empty}}\n"
    with pytest.raises(CheckError, match="/light has the type std_srvs/srv/Empty here and std_srvs/srv/SetBool at"):
        play.graph(extended(SERVER, client, "Tick.tick -> Client.execIn"))


# The client


def test_a_call_is_sent_at_the_end_of_the_tick_and_its_response_fires_later(context: RecordingContext) -> None:
    client = of(Client, context, request__data=True)
    peer = PeerServer(context.transport)
    client.compute()
    assert peer.requests == []
    context.services.network.flush()
    assert [data for _, data in peer.requests] == [True]
    context.tick()
    assert client.update() is None
    peer.answer("on")
    context.tick()
    assert (client.update(), client.active) == (client.exec_out, False)
    assert (client.response__success, client.response__message) == (True, "on")


def test_every_execution_is_a_call_and_every_response_fires_once_in_order_of_arrival(
    context: RecordingContext,
) -> None:
    client = of(Client, context)
    peer = PeerServer(context.transport)
    for data in (True, False, True):
        client.request__data = data
        client.compute()
    context.services.network.flush()
    assert [data for _, data in peer.requests] == [True, False, True]
    for text, index in (("second", 1), ("first", 0), ("third", 0)):
        peer.answer(text, index)
    context.tick()
    found = []
    while client.active:
        assert client.update() == client.exec_out
        found.append((client.response__message, client.response__success))
    assert found == [("second", False), ("first", True), ("third", True)]


def test_calls_wait_for_a_server_up_to_the_depth_of_the_qos(context: RecordingContext) -> None:
    client = of(Client, context, qos_profile='{"depth": 2}')
    for data in (True, False, True):
        client.request__data = data
        client.compute()
        context.services.network.flush()
    peer = PeerServer(context.transport)
    context.services.network.flush()
    assert [data for _, data in peer.requests] == [False, True]


def test_a_missing_server_is_reported_once(context: RecordingContext) -> None:
    client = of(Client, context)
    client.compute()
    for _ in range(700):
        context.services.network.flush()
    assert context.logged == [
        (
            "network",
            f"/service_name: no server offers this service with the type {SET_BOOL}; the last 10 calls wait for a server",
        )
    ]


def test_a_response_from_before_a_stop_is_not_output(context: RecordingContext) -> None:
    client = of(Client, context)
    peer = PeerServer(context.transport)
    client.compute()
    context.services.network.flush()
    context.stop(client)
    peer.answer("late")
    client.compute()
    context.services.network.flush()
    peer.answer("in time")
    context.tick()
    assert client.update() == client.exec_out
    assert (client.response__message, client.active) == ("in time", False)


def test_a_request_field_that_does_not_fit_is_refused_in_setup(context: RecordingContext) -> None:
    made: Any = grown(Client, names("sensor_msgs/srv/SetCameraInfo"), DEFINITIONS)
    field = made.ports["inputs:Request:camera_info:k"].field
    with pytest.raises(ContextError, match="Request:camera_info:k has 1 elements, not 9"):
        ready(made, context, message_package="sensor_msgs", message_name="SetCameraInfo", **{field: [1.0]})


# In a graph


# isaacsim.ros2.nodes/python/tests/test_service.py, test_service: a client and a server in one graph
def test_a_client_gets_the_response_of_a_server_in_the_same_graph(play: Player) -> None:
    playing = play.graph(BOTH)
    client = playing.node("Client")
    seen = playing.each_tick(4, lambda: (client.response__success, client.response__message))
    assert seen == [(False, ""), (False, ""), (True, "done"), (True, "done")]


def test_nodes_after_a_client_run_once_for_each_response(play: Player) -> None:
    playing = play.graph(extended(BOTH, "  Count: omni.graph.action.Counter\n", "Client.execOut -> Count.execIn"))
    assert playing.each_tick(6, lambda: playing.node("Count").count) == [0, 0, 0, 1, 2, 3]


@pytest.mark.parametrize("cls", [Client, Request, Response])
def test_check_node_accepts_the_service_nodes_with_their_ports(cls: type[Node]) -> None:
    made = grown(cls, names(SET_BOOL), DEFINITIONS)
    inputs = {"message_package": "std_srvs", "message_name": "SetBool"}

    def surroundings() -> RecordingContext:
        context = RecordingContext()
        if cls is Response:
            context.service_server(SET_BOOL, "light")
        else:
            Peer(context.transport, "/service_name").ask(True)
        return context

    check_node(made, surroundings, **inputs, **({"server_handle": 1} if cls is Response else {}))
