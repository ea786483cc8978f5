"""Action servers of nodes: goals by tick, the rules of rcl_action, and what ends with the graph."""

from __future__ import annotations

import uuid
from typing import Any

import pytest

from graphengine.messages import goals, messages
from graphengine.messages.actions import ActionServer, Goal
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.goals import ABORTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, UNKNOWN
from graphengine.testing.recording_context import RecordingContext
from tests.action_peer import STEPS, ActionPeer

ONE, OTHER = uuid.UUID(int=1), uuid.UUID(int=2)


class Served:
    """An action server of a node, and its client."""

    def __init__(self) -> None:
        self.context = RecordingContext(wanted=False)
        self.server: ActionServer = self.context.action_server(STEPS, "steps")
        self.peer = ActionPeer(self.context.transport, "/steps")

    def tick(self, ticks: int = 1) -> list[Goal]:
        """Begin a tick; return the goals that arrived."""
        self.context.tick(ticks)
        return list(self.server.goals())

    def end(self) -> None:
        """End a tick."""
        self.server.update()
        self.context.services.network.flush()

    def accepted(self, goal: uuid.UUID = ONE) -> Goal:
        """Send a goal and accept it."""
        self.peer.send(goal, steps=3)
        (found,) = self.tick()
        found.accept()
        self.end()
        return found


@pytest.fixture
def served() -> Served:
    return Served()


def result(steps: str = "done") -> Any:
    made = DEFINITIONS.initial(f"{STEPS}_Result")
    made.result.error_message = steps
    return made


def test_a_goal_is_seen_in_the_next_tick_and_answered_at_its_end(served: Served) -> None:
    served.peer.send(ONE, steps=3)
    assert served.server.goals() == []
    (goal,) = served.tick()
    assert (goal.identity, goal.message.steps) == (ONE.bytes, 3)
    goal.accept()
    assert served.peer.accepted == []
    served.end()
    assert served.peer.accepted == [True]
    assert served.peer.status == [[EXECUTING]]
    assert served.tick() == []


def test_a_rejected_goal_is_unknown(served: Served) -> None:
    served.peer.send(ONE, steps=3)
    (goal,) = served.tick()
    goal.reject()
    served.peer.ask_result(ONE)
    served.end()
    served.tick()
    served.end()
    assert served.peer.accepted == [False]
    assert [answer.status for answer in served.peer.results] == [UNKNOWN]
    assert served.peer.status == []


def test_a_goal_with_the_uuid_of_another_is_rejected(served: Served) -> None:
    served.accepted()
    served.peer.send(ONE)
    assert served.tick() == []
    served.end()
    assert served.peer.accepted == [True, False]


def test_result_requests_get_their_response_at_the_end_of_the_goal_even_if_they_came_earlier(served: Served) -> None:
    goal = served.accepted()
    served.peer.ask_result(ONE)
    served.tick()
    served.end()
    assert served.peer.results == []
    served.tick()
    goal.succeed(result())
    served.end()
    served.peer.ask_result(ONE)
    served.tick()
    served.end()
    told = [(answer.status, answer.result.result.error_message) for answer in served.peer.results]
    assert told == [(SUCCEEDED, "done")] * 2
    assert served.peer.status == [[EXECUTING], [SUCCEEDED]]


def test_an_ended_goal_keeps_its_result_and_drops_the_message_of_the_client(served: Served) -> None:
    goal = served.accepted()
    before = served.server.save()
    goal.succeed(result())
    assert (goal.ended, goal.message) == (True, None)
    served.server.restore(before)
    assert (goal.active, goal.message.steps) == (True, 3)


def test_results_are_discarded_after_the_timeout(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(goals, "RESULT_TIMEOUT", 1.0)
    served.accepted().succeed()
    second = round(1.0 / served.context.clock.delta)
    for ticks in (1, second - 1, 2, 1):
        served.peer.ask_result(ONE)
        served.tick(ticks)
        served.end()
    assert [answer.status for answer in served.peer.results] == [SUCCEEDED, SUCCEEDED, SUCCEEDED, UNKNOWN]
    assert served.peer.status[-1] == []


def test_feedback_has_the_uuid_of_its_goal_and_is_sent_only_to_subscribers() -> None:
    served = Served()
    goal = served.accepted()
    feedback = DEFINITIONS.initial(f"{STEPS}_Feedback")
    feedback.completed_steps = 2
    goal.feedback(feedback)
    served.end()
    (heard,) = served.peer.feedback
    assert (bytes(heard.goal_id.uuid), heard.feedback.completed_steps) == (ONE.bytes, 2)
    alone = RecordingContext(wanted=False)
    server = alone.action_server(STEPS, "steps")
    lonely = Goal(server, ONE.bytes, None, b"")
    lonely.feedback(feedback)
    assert alone.services.network.outbox == []  # type: ignore[attr-defined]


@pytest.mark.parametrize("how", ["one", "all", "by time"])
def test_goals_are_cancelled_by_uuid_by_time_or_all(served: Served, how: str) -> None:
    goal = served.accepted()
    stamp = messages.stamp(served.context.clock.time)
    arguments = {"one": (ONE, None), "all": (None, None), "by time": (None, stamp)}
    served.peer.cancel(*arguments[how])
    served.tick()
    assert goal.cancel_requested
    served.end()
    (answer,) = served.peer.cancelled
    assert [bytes(info.goal_id.uuid) for info in answer.goals_canceling] == [ONE.bytes]
    assert answer.return_code == 0
    goal.canceled(result("stopped"))
    served.end()
    assert served.peer.status == [[EXECUTING], [CANCELING], [CANCELED]]


def test_a_refused_cancellation_has_the_return_code_of_rcl_action(served: Served) -> None:
    goal = served.accepted()
    served.peer.cancel(OTHER)
    served.peer.cancel(ONE)
    served.peer.cancel(ONE)
    served.peer.cancel(None)
    served.tick()
    goal.canceled()
    served.peer.cancel(ONE)
    served.tick()
    served.end()
    unknown, none, terminated = 2, 0, 3
    assert [answer.return_code for answer in served.peer.cancelled] == [unknown, none, terminated, none, terminated]


def test_a_goal_ends_only_once_and_becomes_canceled_only_after_a_request(served: Served) -> None:
    goal = served.accepted()
    with pytest.raises(ValueError, match="a goal that is executing cannot become canceled"):
        goal.canceled()
    goal.abort()
    with pytest.raises(ValueError, match="a goal that is aborted cannot become succeeded"):
        goal.succeed()


def test_only_results_of_the_action_end_a_goal(served: Served) -> None:
    goal = served.accepted()
    with pytest.raises(messages.MessageError):
        goal.succeed(DEFINITIONS.initial(f"{STEPS}_Feedback"))
    assert goal.active


def test_a_stop_aborts_active_goals_and_rejects_pending_goals(served: Served) -> None:
    served.accepted()
    served.peer.ask_result(ONE)
    served.tick()
    served.peer.send(OTHER)
    served.tick()
    served.context.stop()
    assert served.peer.accepted == [True, False]
    assert [answer.status for answer in served.peer.results] == [ABORTED]
    assert served.peer.status[-1] == [ABORTED]
    served.peer.ask_result(ONE)
    served.tick()
    served.end()
    assert [answer.status for answer in served.peer.results] == [ABORTED, ABORTED]


def test_closing_aborts_goals(served: Served) -> None:
    served.accepted()
    served.peer.ask_result(ONE)
    served.tick()
    served.context.close()
    assert [answer.status for answer in served.peer.results] == [ABORTED]
    assert served.context.services.actions == []


def test_an_action_server_keeps_its_goals_when_its_graph_is_exchanged(served: Served) -> None:
    goal = served.accepted()
    served.peer.ask_result(ONE)
    before = served.context
    with before.services.network.handing_over():
        after = RecordingContext.__new__(RecordingContext)
        after.__dict__.update(before.__dict__, _closing=[], _servers=0)
        server = after.action_server(STEPS, "steps")
    assert server is served.server
    before.close()
    served.tick()
    assert goal.active
    goal.succeed()
    served.end()
    assert [answer.status for answer in served.peer.results] == [SUCCEEDED]
    after.close()


def test_restoring_a_checkpoint_restores_the_goals(served: Served) -> None:
    goal = served.accepted()
    services = served.context.services
    saved = services.save(), services.network.save()
    for _ in range(2):
        goal.succeed(result())
        served.peer.send(OTHER)
        (other,) = served.tick()
        other.accept()
        served.end()
        assert served.peer.status[-1] == [SUCCEEDED, EXECUTING]
        services.network.restore(saved[1])
        services.restore(saved[0])
        assert goal.active
        served.end()
        assert served.peer.status[-1] == [EXECUTING]


def test_goals_beyond_the_limit_are_rejected(served: Served) -> None:
    for number in range(goals.MAX_ACTIVE + 1):
        served.peer.send(uuid.UUID(int=number + 1))
    for goal in served.tick():
        goal.accept()
    served.end()
    assert served.peer.accepted.count(True) == goals.MAX_ACTIVE
    assert served.peer.accepted.count(False) == 1


def test_malformed_requests_are_dropped_with_one_warning(served: Served) -> None:
    name, kind = goals.parts("/steps", STEPS)["send_goal"]
    client = served.context.transport.client(name, kind, goals.FEEDBACK_QOS, lambda number, data: None)
    for data in (b"", b"\0\1\0\0\7", b"\0\1\0\0"):
        client.call(data)
    assert served.tick() == []
    assert served.context.logged == [
        ("network", f"{name}: a peer sends malformed {kind}_Request messages; they are dropped")
    ]
