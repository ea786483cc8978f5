"""`graphrun action`: actions of a live network, in the form of ros2cli."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator

import pytest

from graphengine.messages.goals import ABORTED, SUCCEEDED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.action_graph import FIBONACCI
from tests.action_peer import ActionServerPeer
from tests.cli.harness import Graphrun, live
from tests.waiting import PATIENCE, eventually


@pytest.fixture
def peer(domain_id: int) -> Iterator[DdsTransport]:
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "OFF"), "peer", "/robots"))) as transport:
        yield transport


@pytest.fixture
def server(peer: DdsTransport) -> ActionServerPeer:
    return ActionServerPeer(peer, "/fibonacci", FIBONACCI)


@pytest.fixture
def action(graphrun: Graphrun) -> Graphrun:
    """`graphrun action` in this process."""
    return lambda verb, *arguments, **ended: graphrun("action", verb, *arguments, "--transport", "dds", **ended)


@contextlib.contextmanager
def answering(server: ActionServerPeer, accepted: bool = True, status: int = SUCCEEDED) -> Iterator[None]:
    """A thread in which the server answers one goal, with feedback and a result."""

    def answer() -> None:
        eventually(lambda: server.goals)
        server.answer_goal(accepted=accepted)
        if accepted:
            server.say(server.goals[0], sequence=[0])
            eventually(lambda: server.asked)
            server.answer_result(status, sequence=[0, 1])

    thread = threading.Thread(target=answer)
    thread.start()
    yield
    thread.join(PATIENCE)


def test_list_names_actions_and_their_types(action: Graphrun, server: ActionServerPeer) -> None:
    assert action("list", code=0, err="").out == "/fibonacci\n"
    assert action("list", "-t", code=0, err="").out == f"/fibonacci [{FIBONACCI}]\n"
    assert action("list", "-c", code=0, err="").out == "1\n"


def test_an_empty_list_names_the_searched_domain(action: Graphrun, domain_id: int) -> None:
    assert action("list", code=0, out="").err.startswith("no actions on domain ")


def test_info_names_clients_and_servers(action: Graphrun, server: ActionServerPeer) -> None:
    text = "Action: /fibonacci\nAction clients: 0\nAction servers: 1\n"
    assert action("info", "/fibonacci", code=0, err="").out == f"{text}    /robots/peer\n"
    assert action("info", "fibonacci", "-t", code=0, err="").out == f"{text}    /robots/peer [{FIBONACCI}]\n"
    assert action("info", "/fibonacci", "-c", code=0, err="").out == text


def test_info_of_an_unknown_action_suggests_another(action: Graphrun, server: ActionServerPeer) -> None:
    assert "unknown action '/fibonaci'\ndid you mean '/fibonacci'?" in action("info", "/fibonaci", code=1, out="").err


@pytest.mark.parametrize(("status", "word", "code"), [(SUCCEEDED, "SUCCEEDED", 0), (ABORTED, "ABORTED", 1)])
def test_send_goal_prints_acceptance_feedback_and_result(
    action: Graphrun, server: ActionServerPeer, status: int, word: str, code: int
) -> None:
    with answering(server, status=status):
        result = action(
            "send_goal", "/fibonacci", "example_interfaces/Fibonacci", "{order: 3}", "-f", code=code, err=""
        )
    assert [message.order for message in server.messages] == [3]
    assert result.out == (
        "Waiting for an action server to become available...\n"
        "Sending goal:\n     order: 3\n\n"
        f"Goal accepted with ID: {server.goals[0].hex()}\n\n"
        "Feedback:\n    sequence:\n- 0\n\n"
        "Result:\n    sequence:\n- 0\n- 1\n\n"
        f"Goal finished with status: {word}\n"
    )


def test_send_goal_reports_a_rejected_goal(action: Graphrun, server: ActionServerPeer) -> None:
    with answering(server, accepted=False):
        result = action("send_goal", "/fibonacci", FIBONACCI, code=1, err="")
    assert result.lines[-1] == "Goal was rejected."


def test_send_goal_refuses_an_illegal_goal(action: Graphrun, server: ActionServerPeer) -> None:
    assert "did you mean 'order'?" in action("send_goal", "/fibonacci", FIBONACCI, "{ordr: 3}", code=1, out="").err
    assert "did you mean 'Fibonacci'?" in action("send_goal", "/a", "example_interfaces/Fibonaci", code=1, out="").err
    assert server.goals == []


def test_ctrl_c_cancels_the_goal(domain_id: int) -> None:
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as peer:
        server = ActionServerPeer(peer, "/fibonacci", FIBONACCI)
        with live("action", "send_goal", "/fibonacci", FIBONACCI, "--transport", "dds", env=env, out=True) as sending:
            assert eventually(lambda: server.goals)
            server.answer_goal()
            assert sending.hear(lambda said: "Goal accepted" in said)
            sending.process.send_signal(signal.SIGINT)
            assert eventually(lambda: server.cancelled)
            server.answer_cancel()
            assert sending.hear(lambda said: said.endswith("Canceling goal...\nGoal canceled.\n"))
            assert sending.process.wait(PATIENCE) == 1
