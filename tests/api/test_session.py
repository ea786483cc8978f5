"""Sessions: time, states, commands, threads."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.control.client import Client, find
from graphengine.recording.reader import Recording
from graphengine.recording.sources import Workspace
from graphengine.testing import session
from tests.api.conftest import Start
from tests.waiting import PATIENCE

FAILING = """
nodes: {Tick: OnPlaybackTick, Fails: {type: api.Fails, inputs: {at: 3}}}
connections: [Tick.tick -> Fails.execIn]
"""
COUNTING = FAILING.replace("at: 3", "at: -1")


# Time


def test_a_session_is_stopped_then_playing_then_paused(start: Start) -> None:
    sim = start(COUNTING)
    assert (sim.state, sim.time, sim.tick) == ("stopped", 0.0, 0)
    seen = []
    sim.run(1.0, until=lambda s: seen.append(s.state) or False)  # type: ignore[func-returns-value]
    assert seen == ["stopped"] + 60 * ["playing"]
    assert (sim.state, sim.time, sim.tick) == ("paused", 1.0, 60)
    sim.step(3)
    assert (sim.state, sim.tick) == ("paused", 63)
    sim.reset()
    assert (sim.time, sim.value("Fails.count")) == (0.0, 0)


def test_a_run_tells_whether_its_condition_held(start: Start) -> None:
    sim = start(COUNTING)
    assert sim.run(1.0, until=lambda s: s.value("Fails.count") == 5)
    assert sim.tick == 5
    assert sim.run(1.0, until=lambda s: s.tick == 5)
    assert sim.tick == 5
    assert not sim.run(0.5, until=lambda s: False)
    assert sim.tick == 35
    assert sim.run(0.5)
    sim.interrupt()
    assert not sim.run(0.5)
    sim.interrupt()
    assert sim.run(0.5, until=lambda s: True)
    assert sim.run(0.5)


def test_a_condition_that_raises_leaves_the_session_usable(start: Start) -> None:
    sim = start(COUNTING)
    with pytest.raises(ZeroDivisionError):
        sim.run(until=lambda s: 1 // (2 - s.tick) > 1)
    assert (sim.state, sim.tick) == ("paused", 2)
    sim.step()


def test_ticks_cannot_be_asked_for_within_a_run(start: Start) -> None:
    sim = start(COUNTING)
    for ask in (lambda s: s.step(), lambda s: s.close()):
        with pytest.raises(ge.StateError, match="the session is running"):
            sim.run(1.0, until=ask)
    assert sim.tick == 0


@pytest.mark.parametrize(("arguments", "words"), [((-1.0, None), "seconds"), ((1.0, 0.0), "rate")])
def test_times_that_make_no_sense_are_told(start: Start, arguments: tuple[float, float | None], words: str) -> None:
    with pytest.raises(ge.UsageError, match=f"^{words}: expected"):
        start(COUNTING).run(*arguments)


# After a failure


def test_a_session_that_failed_can_be_read_and_reset_and_nothing_else(start: Start, tmp_path: Path) -> None:
    sim = start(FAILING, record=tmp_path / "out.mcap")
    with pytest.raises(ge.NodeError, match="as it was told"):
        sim.run(1.0)
    assert (sim.state, sim.value("Fails.count"), sim.value("Fails.state:total")) == ("failed", 3, 6)
    forbidden: list[Callable[[], object]] = [
        sim.step,
        sim.run,
        lambda: sim.set("Fails.at", 9),
        lambda: sim.press("W"),
        lambda: sim.subscribe("/a", type="std_msgs/msg/String"),
    ]
    for ask in forbidden:
        with pytest.raises(ge.StateError, match="the session failed; reset it first"):
            ask()
    sim.reset()
    assert sim.state == "paused"
    sim.set("Fails.at", 9)
    sim.step(4)
    failure = Recording(tmp_path / "out.mcap", Workspace(tmp_path)).failure
    assert "node Fails (api.Fails) raised ArithmeticError: as it was told" in failure


def test_with_keep_going_a_node_that_raises_is_logged(start: Start) -> None:
    logged: list[tuple[str, ...]] = []
    sim = start(FAILING, keep_going=True, log=lambda *line: logged.append(line))
    assert sim.run(0.1)
    ((severity, node, text),) = logged
    assert (severity, node) == ("error", "")
    assert "as it was told" in text


def test_a_closed_session_is_closed(start: Start) -> None:
    sim = start(COUNTING)
    future = sim.submit("pause")
    sim.close()
    sim.close()
    assert repr(sim) == "<Session of g: closed, t = 0.000 s>"
    with pytest.raises(ge.StateError, match="the session is closed"):
        sim.step()
    with pytest.raises(ge.StateError):
        future.result(0)


# Threads


def test_another_thread_may_submit_and_interrupt_and_nothing_else(start: Start) -> None:
    sim, refused = start(COUNTING), []

    def outside() -> object:
        for ask in (lambda: sim.time, sim.step, lambda: sim.value("Fails.count"), sim.close):
            try:
                ask()
            except ge.StateError as error:
                refused.append("another thread uses this session" in str(error))
        try:
            return sim.submit("set", {"address": "Fails.label", "value": "later"}).result(PATIENCE)
        finally:
            sim.interrupt()

    began = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(lambda: (began.wait(PATIENCE), outside()))
        assert not sim.run(until=lambda s: began.set() or False)  # type: ignore[func-returns-value]
        done.result(PATIENCE)
    assert refused == 4 * [True]
    assert sim.value("Fails.label") == "later"


def test_what_is_submitted_is_done_before_the_next_tick_or_refused(start: Start) -> None:
    sim = start(COUNTING)
    state, wrong = sim.submit("state"), sim.submit("stat")
    sim.step()
    assert (state.result(0)["tick"], state.result(0)["state"]) == (0, "stopped")
    with pytest.raises(ge.UsageError, match="did you mean 'state'"):
        wrong.result(0)


def test_ctrl_c_ends_a_run_between_two_ticks(start: Start) -> None:
    sim = start(COUNTING)
    with pytest.raises(KeyboardInterrupt):
        sim.run(until=lambda s: s.tick == 5 and bool(os.kill(os.getpid(), signal.SIGINT)))  # type: ignore[func-returns-value]
    assert (sim.state, sim.tick) == ("paused", 5)
    assert sim.run(0.1)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_ends_a_wait_for_the_next_tick_at_once(start: Start) -> None:
    sim = start(COUNTING)
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    began = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        sim.run(100.0, rate=0.01)
    timer.join()
    assert sim.tick <= 1 + (time.monotonic() - began) * 0.6


# Commands


def test_robots_are_moved_pushed_spawned_and_removed(sim: ge.Session) -> None:
    sim.move("dd100", position=(1.0, 2.0), orientation=(0.0, 0.0, 1.0, 0.0))
    robot = sim.robots["dd100"]
    assert robot.pose.position[:2] == (1.0, 2.0)
    assert robot.pose.orientation == pytest.approx((0.0, 0.0, 1.0, 0.0))
    sim.push("dd100", impulse=(0.0, 20.0, 0.0))
    sim.step(2)
    assert robot.velocity.linear[1] > 0.2
    second = sim.spawn("second", "robots/dd100.yaml", position=(0.0, 5.0, 0.03), namespace="second")
    assert second.namespace == "second"
    assert list(sim.robots) == ["dd100", "second"]
    assert set(second.joints) == {"front_left_wheel_joint", "front_right_wheel_joint"}
    assert repr(second).startswith("<Robot second at (0.000, 5.000, 0.03")
    sim.remove("second")
    assert list(sim.robots) == ["dd100"]
    assert repr(second) == "<Robot second>"
    with pytest.raises(ge.UnknownEntityError):
        _ = second.pose


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda sim: sim.robots["dd10"], "no robot 'dd10'\n  did you mean 'dd100'?"),
        (lambda sim: sim.move("dd100"), "move: give a position, an orientation, or a velocity"),
        (lambda sim: sim.move("dd100", position=("a", 2.0)), "move: position[0]: expected a number, got 'a'"),
        (lambda sim: sim.move("dd10", position=(1.0, 2.0)), "dd10"),
        (lambda sim: sim.push("dd100", force=(0.0, 80.0, 0.0)), "push: a force needs a duration (s)"),
        (lambda sim: sim.spawn("second", "robots/dd10.yaml"), "robots/dd10.yaml"),
        (lambda sim: sim.remove("second"), "no robot 'second'"),
        (lambda sim: sim.press("Q1"), "Q1"),
        (lambda sim: sim.impulse("Node"), "no OnImpulseEvent node 'Node'"),
        (lambda sim: sim.reset("speed"), "reset: scope"),
        (lambda sim: sim.step(-1), "ticks: expected 0 or more"),
        (lambda sim: sim.variables("dd100/cmd"), "no graph matches 'dd100/cmd'\n  did you mean 'dd100/cmd_vel'?"),
        (lambda sim: sim.picture("topp"), "topp: there is no view or camera with this name or path"),
    ],
)
def test_commands_that_make_no_sense_are_told(sim: ge.Session, ask: Callable[[ge.Session], object], words: str) -> None:
    with pytest.raises(ge.GraphError) as caught:
        ask(sim)
    assert words in str(caught.value)


def test_a_session_is_found_by_its_name_where_it_is_to_be_controlled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with session("dd100_flat", control="bench") as sim, ThreadPoolExecutor(1) as pool:
        asked = pool.submit(lambda: _ask(Client(find("bench"))))
        sim.run(until=lambda s: asked.done())
        assert asked.result(0)["state"] == "playing"
    assert not list(tmp_path.rglob("bench.*"))


def _ask(client: Client) -> Any:
    with client:
        return client.ask("state")
