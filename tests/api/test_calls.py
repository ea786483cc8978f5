"""Service calls and goals that run while ticks run, and the bodies of a session."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.format.errors import StateError, TransportError, UnknownEntityError, UsageError
from graphengine.recording.reader import Recording
from graphengine.recording.sources import Workspace
from tests import action_graph, service_graph


@pytest.fixture
def light() -> Iterator[ge.Session]:
    with ge.load(text=f"graph: light\n{service_graph.SERVER}").session() as sim:
        yield sim


@pytest.fixture
def fibonacci() -> Iterator[ge.Session]:
    with ge.load(text=f"graph: count\n{action_graph.SERVER}").session() as sim:
        yield sim


def test_a_call_does_not_wait_for_its_response(light: ge.Session) -> None:
    with light.start_call("/light", {"data": True}) as call:
        assert call.ready
        assert not call.done
        with pytest.raises(TransportError, match="/light: no response"):
            call.response  # noqa: B018
        assert light.run(1.0, until=lambda _: call.done)
        assert (call.response.success, call.response.message) == (True, "done")


def test_a_call_without_a_request_only_looks_for_a_server(light: ge.Session) -> None:
    with light.start_call("/light", None) as call, light.start_call("/dark", None, "std_srvs/srv/SetBool") as other:
        light.run(0.1)
        assert (call.ready, call.done, other.ready) == (True, False, False)


def test_a_goal_goes_from_sent_to_succeeded_with_feedback_and_result(fibonacci: ge.Session) -> None:
    with fibonacci.send_goal("/fibonacci", {"order": 3}) as goal:
        seen = [goal.status]
        while not goal.done:
            fibonacci.step()
            seen.append(goal.status)
        assert list(dict.fromkeys(seen)) == ["sent", "accepted", "succeeded"]
        assert goal.result.sequence.tolist() == [0, 1, 1]
        assert goal.feedback.sequence.tolist() == [0, 1]


def test_a_goal_has_no_result_before_its_end(fibonacci: ge.Session) -> None:
    with fibonacci.send_goal("fibonacci", {"order": 3}) as goal, pytest.raises(StateError, match="the goal is sent"):
        goal.result  # noqa: B018


def test_a_goal_for_an_unknown_action_is_refused(fibonacci: ge.Session) -> None:
    with pytest.raises(UsageError, match="no graph uses service '/fibonaci/_action/send_goal'"):
        fibonacci.send_goal("/fibonaci", {})


def test_bodies_are_found_by_name_or_path() -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        robot, wheel = sim.body("dd100"), sim.body("/dd100/Geometry/base_link/chassis_link")
        assert robot.pose == sim.robots["dd100"].pose
        assert wheel.pose.position[2] == pytest.approx(robot.pose.position[2], abs=0.2)
        assert robot.touched == ("floor",)
        with pytest.raises(UnknownEntityError, match="did you mean 'dd100'"):
            sim.body("dd10")
        with pytest.raises(UnknownEntityError, match="/dd100/nowhere"):
            sim.body("/dd100/nowhere")


def test_a_mark_is_in_the_recording_at_its_tick(tmp_path: Path) -> None:
    with ge.load("dd100_flat", rays="mujoco").session(record=tmp_path / "out.mcap") as sim:
        sim.step(5)
        sim.mark("halfway")
        sim.step(5)
    assert Recording(tmp_path / "out.mcap", Workspace(tmp_path)).verdicts() == {5: ["halfway"]}
