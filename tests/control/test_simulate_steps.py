"""The action SimulateSteps as its clients see it: goals, news of each step, results, and what is cancelled."""

from __future__ import annotations

import queue
import uuid
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from tests.control.simulators import Simulator
from tests.waiting import PATIENCE, eventually

ACTION = "simulation_interfaces/action/SimulateSteps"
HIDDEN = "simulate_steps/_action"
OK, FAILED = 1, 4
EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)
ENDLESS = 1_000_000


def identity(goal: uuid.UUID) -> Any:
    found = DEFINITIONS.initial("unique_identifier_msgs/msg/UUID")
    found.uuid[:] = list(goal.bytes)
    return found


def send(sim: Simulator, goal: uuid.UUID, steps: int) -> bool:
    fields = {"goal_id": identity(goal), "goal__steps": steps}
    return bool(sim.ask(f"{HIDDEN}/send_goal", f"{ACTION}_SendGoal", **fields).accepted)


def result(sim: Simulator, goal: uuid.UUID) -> tuple[int, int, str]:
    answer = sim.ask(f"{HIDDEN}/get_result", f"{ACTION}_GetResult", goal_id=identity(goal))
    return answer.status, answer.result.result.result, answer.result.result.error_message


def cancel(sim: Simulator, **info: Any) -> Any:
    fields = {f"goal_info__{name}": value for name, value in info.items()}
    return sim.ask(f"{HIDDEN}/cancel_goal", "action_msgs/srv/CancelGoal", **fields)


def begun(sim: Simulator) -> None:
    assert eventually(lambda: sim.session.ticks)


def test_a_goal_runs_its_steps_with_feedback_after_each(sim: Simulator) -> None:
    heard: queue.Queue[Any] = queue.Queue()
    kind = f"{ACTION}_FeedbackMessage"
    sim.transport.reader(f"/{HIDDEN}/feedback", kind, QoS(), lambda data: heard.put(messages.decode(data, kind)))
    goal = uuid.uuid4()
    assert send(sim, goal, 3)
    assert result(sim, goal) == (SUCCEEDED, OK, "")
    assert sim.session.ticks == 3
    news = [heard.get(timeout=PATIENCE) for _ in range(3)]
    assert {bytes(each.goal_id.uuid) for each in news} == {goal.bytes}
    told = [(each.feedback.completed_steps, each.feedback.remaining_steps) for each in news]
    assert told == [(1, 2), (2, 1), (3, 0)]
    assert sim.session.state == "paused"


def test_a_late_subscriber_gets_the_status_of_goals(sim: Simulator) -> None:
    goal = uuid.uuid4()
    send(sim, goal, 2)
    result(sim, goal)
    heard: list[bytes] = []
    sim.transport.reader(f"/{HIDDEN}/status", "action_msgs/msg/GoalStatusArray", LATCHED, heard.append)
    (status,) = messages.decode(heard[-1], "action_msgs/msg/GoalStatusArray").status_list
    assert (bytes(status.goal_info.goal_id.uuid), status.status) == (goal.bytes, SUCCEEDED)


def test_a_cancel_request_with_a_time_includes_goals_of_this_time(sim: Simulator) -> None:
    goal = uuid.uuid4()
    stamp = sim.ask(f"{HIDDEN}/send_goal", f"{ACTION}_SendGoal", goal_id=identity(goal), goal__steps=ENDLESS).stamp
    assert cancel(sim, stamp=messages.Time(stamp.sec - 1, 0)).goals_canceling == []
    assert len(cancel(sim, stamp=stamp).goals_canceling) == 1
    assert result(sim, goal)[0] == CANCELED


@pytest.mark.parametrize("one", [True, False])
def test_a_cancelled_goal_ends_between_two_steps(sim: Simulator, one: bool) -> None:
    goal = uuid.uuid4()
    assert send(sim, goal, ENDLESS)
    begun(sim)
    answer = cancel(sim, **({"goal_id": identity(goal)} if one else {}))
    assert [bytes(info.goal_id.uuid) for info in answer.goals_canceling] == [goal.bytes]
    status, code, text = result(sim, goal)
    assert (status, code) == (CANCELED, FAILED)
    assert text == f"cancelled after {sim.session.ticks} of {ENDLESS} steps"
    assert send(sim, uuid.uuid4(), 1)


def test_cancelling_an_ended_or_unknown_goal_is_refused(sim: Simulator) -> None:
    goal = uuid.uuid4()
    assert cancel(sim, goal_id=identity(goal)).return_code == 2  # unknown
    send(sim, goal, 1)
    result(sim, goal)
    assert cancel(sim, goal_id=identity(goal)).return_code == 3  # at its end


def test_a_second_goal_and_a_goal_without_steps_are_rejected(sim: Simulator) -> None:
    first = uuid.uuid4()
    assert send(sim, first, ENDLESS)
    assert not send(sim, uuid.uuid4(), 1)
    cancel(sim)
    result(sim, first)
    assert not send(sim, uuid.uuid4(), 0)
    assert not send(sim, first, 1)


def test_a_goal_is_aborted_when_the_simulation_plays(sim: Simulator) -> None:
    goal = uuid.uuid4()
    assert send(sim, goal, ENDLESS)
    begun(sim)
    sim.run.ask("play")
    status, code, text = result(sim, goal)
    assert (status, code) == (ABORTED, FAILED)
    assert text


def test_an_unknown_goal_has_no_result(sim: Simulator) -> None:
    assert result(sim, uuid.uuid4())[0] == 0
