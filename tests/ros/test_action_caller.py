"""Clients of actions outside of a session, against a server that answers when it is told to."""

from __future__ import annotations

import pytest

from graphengine.messages import goals
from graphengine.messages.goals import CANCELED, SUCCEEDED
from graphengine.messages.interfaces import MessageTypeError
from graphengine.messages.messages import MessageError
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.action_graph import FEEDBACK, FIBONACCI, GOAL, RESULT
from tests.action_peer import ActionServerPeer


@pytest.fixture
def transport() -> MemoryTransport:
    return MemoryTransport()


@pytest.fixture
def server(transport: MemoryTransport) -> ActionServerPeer:
    return ActionServerPeer(transport, "/fibonacci", FIBONACCI)


@pytest.fixture
def caller(transport: MemoryTransport, server: ActionServerPeer) -> ActionCaller:
    return ActionCaller(transport, "/fibonacci", FIBONACCI)


def test_a_call_gets_acceptance_feedback_and_result(caller: ActionCaller, server: ActionServerPeer) -> None:
    heard: list[object] = []
    call = caller.send(GOAL(7), heard.append)
    assert [message.order for message in server.messages] == [7]
    assert not call.accepted.done()
    server.answer_goal()
    assert call.accepted.result(0) is True
    server.say(call.goal, sequence=[1])
    server.say(bytes(16), sequence=[9])
    server.answer_result(SUCCEEDED, sequence=[0, 1])
    outcome = call.result.result(0)
    assert (outcome.status, list(outcome.result.sequence)) == (SUCCEEDED, [0, 1])
    assert [list(message.sequence) for message in heard if isinstance(message, FEEDBACK)] == [[1]]
    assert isinstance(outcome.result, RESULT)


def test_a_rejected_goal_has_no_result(caller: ActionCaller, server: ActionServerPeer) -> None:
    call = caller.send(GOAL(7))
    server.answer_goal(accepted=False)
    assert call.accepted.result(0) is False
    assert server.asked == []
    assert not call.result.done()


def test_goals_are_cancelled_by_uuid_or_all(caller: ActionCaller, server: ActionServerPeer) -> None:
    call = caller.send(GOAL(7))
    server.answer_goal()
    caller.cancel(call.goal)
    caller.cancel()
    assert server.cancelled == [call.goal, bytes(16)]
    server.answer_result(CANCELED)
    assert call.result.result(0).status == CANCELED


def test_a_caller_is_ready_while_there_is_a_server(transport: MemoryTransport) -> None:
    caller = ActionCaller(transport, "/fibonacci", FIBONACCI)
    assert not caller.ready
    ActionServerPeer(transport, "/fibonacci", FIBONACCI)
    assert caller.ready


def test_a_message_of_another_type_is_not_a_goal(caller: ActionCaller, transport: MemoryTransport) -> None:
    with pytest.raises(MessageError):
        caller.send(FEEDBACK([]))
    with pytest.raises(MessageTypeError, match="std_srvs/srv/SetBool is not an action type"):
        ActionCaller(transport, "/a", "std_srvs/srv/SetBool")


def test_a_malformed_response_fails_its_call(transport: MemoryTransport) -> None:
    name, kind = goals.parts("/fibonacci", FIBONACCI)["send_goal"]
    broken = transport.server(
        name, kind, goals.FEEDBACK_QOS, lambda request_id, data: broken.answer(request_id, b"\0\1")
    )
    call = ActionCaller(transport, "/fibonacci", FIBONACCI).send(GOAL(7))
    with pytest.raises(MessageError, match="cannot be decoded"):
        call.accepted.result(0)
