"""A queue at which other threads ask a running session for something."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from typing import Any

import pytest

from graphengine.format.errors import NodeError, StateError, UsageError
from graphengine.runtime.command_queue import MAX_WAITING, SHARE, CommandQueue
from graphengine.runtime.session_core import SessionCore
from tests.control.conftest import MakeTicking
from tests.control.harness import controlled
from tests.waiting import PATIENCE

RAISES = """
    nodes: {Tick: Tick, Raise: {type: Raise, inputs: {at: 2.0}}}
    connections: [Tick.tick -> Raise.execIn]
"""


def test_a_command_from_another_thread_gets_its_result(ticking: MakeTicking) -> None:
    with controlled(ticking().session, paused=True) as run:
        state = run.ask("state")
    begun = {"state": "paused", "time": 0.0, "tick": 0, "tick_period": 0.25, "rate": "max"}
    assert state == begun | {"robots": [], "objects": []}


def test_commands_are_executed_in_order_of_arrival(ticking: MakeTicking) -> None:
    run = ticking()
    queue = CommandQueue()
    asked = [queue.submit(name) for name in ("play", "state", "pause", "state", "stop", "state")]
    queue.serve(run.session)
    assert [answer.result(0)["state"] for answer in asked[1::2]] == ["playing", "paused", "stopped"]


def test_a_command_during_serve_waits_for_the_next_tick(ticking: MakeTicking) -> None:
    queue, asked = CommandQueue(), list[Future[Any]]()
    first = queue.submit("play")
    first.add_done_callback(lambda _: asked.append(queue.submit("state")))
    session = ticking().session
    queue.serve(session)
    assert not asked[0].done()
    queue.serve(session)
    assert asked[0].result(0)["state"] == "playing"


def test_ticks_continue_during_a_flood_of_commands(ticking: MakeTicking) -> None:
    now = [0.0]
    queue, session = CommandQueue(lambda: now[0]), ticking().session

    def take_long(_: SessionCore) -> None:
        now[0] += SHARE

    asked = [queue.ask(take_long) for _ in range(3)]
    for done in (1, 2, 3):
        queue.serve(session)
        assert [answer.done() for answer in asked].count(True) == done


def test_a_refused_command_does_not_end_the_run(ticking: MakeTicking) -> None:
    with controlled(ticking().session, paused=True) as run:
        with pytest.raises(UsageError, match="cannot have robots"):
            run.ask("spawn", name="late", use={"use": "robots/dd100.yaml"})
        with pytest.raises(UsageError, match="did you mean 'step'"):
            run.ask("stepp")
        run.ask("step")
        assert run.ask("state")["tick"] == 1


def fail(_: SessionCore) -> None:
    raise KeyError("left out")


def test_an_internal_error_in_a_command_is_logged_and_does_not_end_the_run(ticking: MakeTicking) -> None:
    session, told = ticking().session, list[tuple[str, str, str]]()
    session.services.log = lambda *entry: told.append(entry)
    with controlled(session, paused=True) as run:
        with pytest.raises(KeyError):
            run.queue.ask(fail).result(PATIENCE)
        run.ask("step")
    assert run.error is None
    (entry,) = told
    assert entry[:2] == ("error", "")
    assert entry[2].startswith("a request failed with an internal error: KeyError: 'left out'")
    assert "test_command_queue.py" in entry[2]


def test_a_command_that_was_cancelled_in_time_is_not_executed(ticking: MakeTicking) -> None:
    session, queue = ticking().session, CommandQueue()
    assert queue.submit("play").cancel()
    queue.serve(session)
    assert session.state == "stopped"


def test_commands_beyond_the_limit_are_refused() -> None:
    queue = CommandQueue()
    waiting = [queue.submit("play") for _ in range(MAX_WAITING)]
    with pytest.raises(StateError, match="the queue is full"):
        queue.submit("play").result(0)
    assert not any(answer.done() for answer in waiting)


# Single ticks


def test_the_command_step_is_complete_after_its_last_tick(ticking: MakeTicking) -> None:
    run = ticking()
    with controlled(run.session, paused=True) as outside:
        outside.ask("step", ticks=5)
        assert outside.ask("state") | {"tick": 5, "state": "paused"} == outside.ask("state")
    assert run.lines() == [f"Show {n / 4:g}" for n in range(1, 6)]


def test_the_last_ticks_of_a_run_complete_their_command(ticking: MakeTicking) -> None:
    with controlled(ticking().session, seconds=1.0, paused=True) as run:
        run.ask("step", ticks=4)
        run.end()
        assert run.error is None


def test_a_stopped_session_can_run_single_ticks(ticking: MakeTicking) -> None:
    with controlled(ticking().session) as run:
        run.ask("stop")
        run.ask("step", ticks=2)
        assert (run.ask("state")["state"], run.ask("state")["tick"]) == ("paused", 2)


def test_a_playing_session_refuses_the_command_step(ticking: MakeTicking) -> None:
    with controlled(ticking().session) as run, pytest.raises(StateError, match="pause it before running single ticks"):
        run.ask("step")


@pytest.mark.parametrize("other", ["pause", "stop", "play", "reset"])
def test_commands_that_end_single_ticks_cancel_the_rest(ticking: MakeTicking, other: str) -> None:
    session, queue = ticking().session, CommandQueue()
    steps = queue.submit("step", {"ticks": 1_000_000})
    queue.serve(session)
    again = queue.submit("step")
    queue.serve(session)
    with pytest.raises(StateError, match="1000000 ticks of an earlier `step` have not run yet"):
        again.result(0)
    assert not steps.done()
    queue.submit(other)
    queue.serve(session)
    with pytest.raises(StateError, match="cancelled: 1000000 of the ticks did not run"):
        steps.result(0)


def test_an_error_in_a_single_tick_ends_the_run_and_fails_the_command(ticking: MakeTicking) -> None:
    with controlled(ticking(RAISES).session, paused=True) as run:
        run.ask("step")
        with pytest.raises(StateError, match=r"node Raise .*it was to be expected"):
            run.ask("step")
        run.end()
        assert isinstance(run.error, NodeError)


# The end


def test_after_close_all_commands_fail(ticking: MakeTicking) -> None:
    session = ticking().session
    session.queue = queue = CommandQueue()
    waiting = queue.submit("play")
    stepping = queue.submit("step")
    session.close()
    for answer in (waiting, stepping, queue.submit("play")):
        with pytest.raises(StateError, match="the run has ended"):
            answer.result(0)


def test_the_command_quit_ends_the_run(ticking: MakeTicking) -> None:
    with controlled(ticking().session, paused=True) as run:
        run.ask("quit")
        run.end()
        assert run.error is None


def test_wake_ends_a_wait() -> None:
    queue = CommandQueue()
    threading.Timer(0.01, queue.wake).start()
    queue.wait(10 * PATIENCE)  # it would hang for as long


def test_a_command_ends_a_wait(ticking: MakeTicking) -> None:
    queue, session = CommandQueue(), ticking().session
    threading.Timer(0.01, queue.submit, ("play",)).start()
    queue.wait(10 * PATIENCE)
    queue.wait(10 * PATIENCE)  # what has come still waits
    queue.serve(session)
    assert session.state == "playing"
