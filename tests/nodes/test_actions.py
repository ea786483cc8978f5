"""Action nodes: ports of any action, goals one after the other, their cancelling and their ends; and the client's side."""

from __future__ import annotations

import uuid

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import ContextError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.goals import ABORTED, CANCELED, EXECUTING, SUCCEEDED
from graphengine.node import Node
from graphengine.node.node_class import grown
from graphengine.nodes.ros2.actions import (
    ROS2ActionClient,
    ROS2ActionServerFeedback,
    ROS2ActionServerGoal,
    ROS2ActionServerResult,
)
from graphengine.testing import RecordingContext, check_node
from tests.action_graph import BOTH, CLIENT, FIBONACCI, SERVER
from tests.action_peer import ActionPeer, ActionServerPeer
from tests.nodes.harness import Player, Playing, names, ready
from tests.service_graph import extended

ONE, OTHER = uuid.UUID(int=1), uuid.UUID(int=2)


def ports(cls: type[Node]) -> dict[str, str]:
    made = grown(cls, {**names(FIBONACCI), "messageSubfolder": "action"}, DEFINITIONS)
    own = {port.field for port in cls.fields.values()}
    return {f"{port.side}:{port.name}": str(port.type) for port in made.fields.values() if port.field not in own}


def offered(play: Player, text: str = SERVER) -> tuple[Playing, ActionPeer]:
    playing = play.graph(text)
    return playing, ActionPeer(playing.transport, "/fibonacci", FIBONACCI)


# Ports


def test_each_node_has_ports_for_its_part_of_the_action() -> None:
    assert ports(ROS2ActionServerGoal) == {"outputs:Goal:order": "int"}
    assert ports(ROS2ActionServerFeedback) == {"inputs:Feedback:sequence": "int[]"}
    assert ports(ROS2ActionServerResult) == {"inputs:Result:sequence": "int[]"}
    assert ports(ROS2ActionClient) == {
        "inputs:Goal:order": "int",
        "outputs:Feedback:sequence": "int[]",
        "outputs:Result:sequence": "int[]",
    }


def test_a_type_that_is_not_an_action_is_an_error() -> None:
    given = {"messagePackage": "std_srvs", "messageSubfolder": "srv", "messageName": "SetBool"}
    with pytest.raises(ContextError, match="std_srvs/srv/SetBool is not an action type"):
        grown(ROS2ActionClient, given, DEFINITIONS)


@pytest.mark.parametrize("cls", [ROS2ActionServerGoal, ROS2ActionClient])
def test_check_node_accepts_the_action_nodes(cls: type[Node]) -> None:
    made = grown(cls, {**names(FIBONACCI), "messageSubfolder": "action"}, DEFINITIONS)
    check_node(made, message_package="example_interfaces", message_name="Fibonacci")


# The server


def test_a_goal_is_output_and_its_client_gets_feedback_and_a_result(play: Player) -> None:
    playing, peer = offered(play)
    peer.send(ONE, order=7)
    playing.tick()
    peer.ask_result(ONE)
    assert (peer.accepted, playing.node("Server").goal__order, playing.node("Server").is_active) == ([True], 7, True)
    playing.tick(6)
    (result,) = peer.results
    assert (result.status, list(result.result.sequence)) == (SUCCEEDED, [0, 1, 1])
    assert [list(message.feedback.sequence) for message in peer.feedback] == [[0, 1]] * len(peer.feedback)
    assert len(peer.feedback) > 1
    assert peer.status == [[EXECUTING], [SUCCEEDED]]
    assert playing.node("Server").is_active is False


def test_a_new_goal_aborts_the_previous_one(play: Player) -> None:
    playing, peer = offered(play)
    peer.send(ONE)
    playing.tick()
    peer.ask_result(ONE)
    peer.send(OTHER)
    playing.tick()
    assert peer.accepted == [True, True]
    assert [answer.status for answer in peer.results] == [ABORTED]
    assert peer.status[-1] == [ABORTED, EXECUTING]


def test_a_server_without_preemption_rejects_new_goals_while_a_goal_is_active(play: Player) -> None:
    playing, peer = offered(play, SERVER.replace("actionName: fibonacci", "actionName: fibonacci, preempts: false"))
    peer.send(ONE)
    peer.send(OTHER)
    playing.tick(8)
    peer.send(OTHER)
    playing.tick()
    assert peer.accepted == [True, False, True]


@pytest.mark.parametrize("order", [1, 9])
def test_a_graph_can_reject_goals(play: Player, order: int) -> None:
    nodes = """  Large: {type: Compare, inputs: {operation: ">", b: 5}}
  If: {type: Branch}
  Reject:
    type: ROS2ActionServerResult
    inputs: {messagePackage: example_interfaces, messageName: Fibonacci, status: rejected}
"""
    wires = (
        "Server.Goal:order -> Large.a",
        "Server.onGoal -> If.execIn",
        "Large.result -> If.condition",
        "If.execTrue -> Reject.execIn",
        "Server.serverHandle -> Reject.serverHandle",
    )
    playing, peer = offered(play, extended(SERVER, nodes, *wires))
    peer.send(ONE, order=order)
    playing.tick()
    assert peer.accepted == [order < 5]
    assert playing.node("Server").is_active == (order < 5)


def test_a_goal_is_canceled_without_a_node_that_handles_cancelling(play: Player) -> None:
    playing, peer = offered(play)
    peer.send(ONE)
    playing.tick()
    peer.ask_result(ONE)
    peer.cancel(ONE)
    playing.tick()
    assert [answer.status for answer in peer.results] == [CANCELED]


@pytest.mark.parametrize(("status", "expected"), [("canceled", CANCELED), ("aborted", ABORTED)])
def test_a_graph_that_handles_cancelling_ends_the_goal_itself(play: Player, status: str, expected: int) -> None:
    cancelled = f"""  Stop:
    type: ROS2ActionServerResult
    inputs: {{messagePackage: example_interfaces, messageName: Fibonacci, status: {status}, "Result:sequence": [4]}}
"""
    wires = "Server.onCancel -> Stop.execIn", "Server.serverHandle -> Stop.serverHandle"
    playing, peer = offered(play, extended(SERVER, cancelled, *wires))
    peer.send(ONE)
    playing.tick()
    peer.ask_result(ONE)
    peer.cancel()
    playing.tick()
    assert [(answer.status, list(answer.result.sequence)) for answer in peer.results] == [(expected, [4])]


def test_a_result_canceled_without_a_cancel_request_is_sent_as_aborted(play: Player) -> None:
    playing, peer = offered(play, SERVER.replace('"Result:sequence"', 'status: canceled, "Result:sequence"'))
    peer.send(ONE)
    playing.tick()
    peer.ask_result(ONE)
    playing.tick(6)
    assert [answer.status for answer in peer.results] == [ABORTED]


def test_a_goal_ends_when_the_session_stops_or_is_over(play: Player) -> None:
    playing, peer = offered(play)
    for goal in (ONE, OTHER):
        peer.send(goal)
        playing.tick()
        peer.ask_result(goal)
        playing.tick()
        playing.session.stop() if goal == ONE else playing.session.close()
    assert [answer.status for answer in peer.results] == [ABORTED, ABORTED]


def test_a_goal_continues_while_its_graph_is_exchanged(play: Player) -> None:
    playing, peer = offered(play)
    peer.send(ONE)
    playing.tick()
    peer.ask_result(ONE)
    (play.folder / "graph.yaml").write_text("graph: graph\n" + SERVER.replace("[0, 1, 1]", "[5]"), "utf-8")
    playing.command("reload")
    playing.tick(6)
    assert [(answer.status, list(answer.result.sequence)) for answer in peer.results] == [(SUCCEEDED, [5])]


def test_all_nodes_of_a_server_name_the_same_action(play: Player) -> None:
    text = SERVER.replace(
        'inputs: {messagePackage: example_interfaces, messageName: Fibonacci, "Result:sequence": [0, 1, 1]}',
        "inputs: {messagePackage: tf2_msgs, messageName: LookupTransform}",
    )
    told = f"Result: the node is for tf2_msgs/action/LookupTransform, but the action /fibonacci has type {FIBONACCI}"
    with pytest.raises(CheckError, match=told):
        play.graph(text)


def test_a_handle_without_a_server_is_an_error_that_says_where_to_get_a_handle(context: RecordingContext) -> None:
    made = grown(ROS2ActionServerResult, {**names(FIBONACCI), "messageSubfolder": "action"}, DEFINITIONS)
    with pytest.raises(ContextError, match="no action server has the handle 7") as caught:
        ready(made, context, message_package="example_interfaces", message_name="Fibonacci", server_handle=7)
    assert caught.value.help == ("wire serverHandle from a ROS2ActionServerGoal",)


def test_two_servers_of_one_action_are_one_error(play: Player) -> None:
    inputs = "{actionName: fibonacci, messagePackage: example_interfaces, messageName: Fibonacci}"
    second = f"  Second: {{type: ROS2ActionServerGoal, inputs: {inputs}}}\n"
    with pytest.raises(CheckError) as caught:
        play.graph(extended(SERVER, second, "Tick.tick -> Second.execIn"))
    (finding,) = [found for found in caught.value.findings if found.severity == "error"]
    assert "the action /fibonacci has a server here and another in" in finding.message


def test_a_name_that_ros_refuses_is_reported_at_its_place(play: Player) -> None:
    with pytest.raises(CheckError, match=r"graph.yaml:7:26: error G304: Server: action name '/1fib'"):
        play.graph(SERVER.replace("actionName: fibonacci", "actionName: 1fib"))


# The client


def test_a_client_and_a_server_of_one_session_run_an_action(play: Player) -> None:
    playing = play.graph(BOTH)
    client = playing.node("Client")
    statuses = playing.each_tick(9, lambda: client.status)
    assert list(dict.fromkeys(statuses)) == ["sent", "executing", "succeeded"]
    assert list(client.result__sequence) == [0, 1, 1]
    assert list(client.feedback__sequence) == [0, 1]


def sending(play: Player, text: str = CLIENT) -> tuple[Playing, ActionServerPeer]:
    playing = play.graph(text)
    return playing, ActionServerPeer(playing.transport, "/fibonacci", FIBONACCI)


def test_a_rejected_goal_fires_its_own_port(play: Player) -> None:
    nodes = "  Count: {type: Counter}\n"
    playing, peer = sending(play, extended(CLIENT, nodes, "Client.onRejected -> Count.execIn"))
    playing.tick()
    peer.answer_goal(accepted=False)
    playing.tick(3)
    assert (playing.node("Client").status, playing.node("Count").count) == ("rejected", 1)
    assert peer.asked == []


def test_feedback_on_other_goals_is_not_output(play: Player) -> None:
    playing, peer = sending(play)
    playing.tick()
    peer.answer_goal()
    peer.say(bytes(16), sequence=[9])
    playing.tick()
    assert list(playing.node("Client").feedback__sequence) == []
    peer.say(peer.goals[0], sequence=[3])
    playing.tick()
    assert list(playing.node("Client").feedback__sequence) == [3]


@pytest.mark.parametrize("early", [True, False])
def test_a_goal_can_be_cancelled_before_it_is_accepted(play: Player, early: bool) -> None:
    wires = "Tick.tick -> If.execIn", "If.execTrue -> Client.cancel"
    playing, peer = sending(play, extended(CLIENT, "  If: {type: Branch}\n", *wires))
    playing.tick()
    if early:
        playing.command("set", address="If.condition", value=True)
        playing.tick()
        assert peer.cancelled == []
    peer.answer_goal()
    playing.tick()
    playing.command("set", address="If.condition", value=True)
    playing.tick(3)
    assert peer.cancelled == peer.goals
    peer.answer_result(CANCELED, sequence=[1])
    playing.tick()
    assert (playing.node("Client").status, list(playing.node("Client").result__sequence)) == ("canceled", [1])


def test_uuids_of_goals_are_unique_and_equal_in_equal_runs(play: Player) -> None:
    text = CLIENT.replace("Once.once -> Client.execIn", "Tick.tick -> Client.execIn")
    runs = []
    for _ in range(2):
        playing, peer = sending(play, text)
        playing.tick(3)
        runs.append(peer.goals)
    assert runs[0] == runs[1]
    assert len(set(runs[0])) == 3


def test_an_action_continues_from_a_checkpoint_as_in_the_first_run(play: Player) -> None:
    playing = play.graph(BOTH)
    playing.tick(4)
    playing.command("checkpoint", name="here")

    def rest() -> list[tuple[str, list[int], bytes]]:
        client, server = playing.node("Client"), playing.node("Server").server
        goals = server._goals
        return playing.each_tick(8, lambda: (client.status, [goal.status for goal in goals], client.latest))

    before = rest()
    playing.command("restore", name="here")
    assert rest() == before
    assert before[-1][0] == "succeeded"


def test_a_client_sends_goals_with_new_uuids_after_a_stop(play: Player) -> None:
    playing, peer = sending(play)
    playing.tick(2)
    playing.session.stop()
    playing.tick(2)
    assert len(set(peer.goals)) == 2
