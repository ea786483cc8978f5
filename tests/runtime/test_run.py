"""How a run goes on: its pace, its pauses, and when it ends."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from graphengine.format.errors import StateError
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.pacer import Pacer
from graphengine.runtime.run_control import IDLE
from graphengine.runtime.session_core import SessionCore
from tests.compiler.conftest import MakePlay

SHOWS_TIME = """
    nodes: {Tick: Tick, Show: Do}
    connections:
      - Tick.tick -> Show.execIn
      - Tick.time -> Show.a
"""


class Time:
    """A wall clock that only sleeping moves."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        self.slept: list[float] = []
        monkeypatch.setattr("time.perf_counter", lambda: self.now)
        monkeypatch.setattr("time.sleep", self.sleep)

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


class ScriptedQueue(CommandQueue):
    """A queue at which, each time that the session would sleep, the next thing happens."""

    def __init__(self, time: Time, *script: Callable[[SessionCore], object]) -> None:
        super().__init__(lambda: 0.0)
        self.time = time
        self.script = list(script)
        self.waits: list[float] = []

    def wait(self, seconds: float) -> None:
        self.waits.append(seconds)
        if self.script:
            self.ask(self.script.pop(0))
        else:
            self.time.now += seconds


@pytest.fixture
def time(monkeypatch: pytest.MonkeyPatch) -> Time:
    return Time(monkeypatch)


# Pace


def test_ticks_begin_at_equal_intervals_of_wall_time(play: MakePlay, time: Time) -> None:
    run, begun = play(SHOWS_TIME, tick_period=(1, 4)), []

    def take(session: SessionCore) -> bool:
        begun.append(time.now)
        time.now += 0.1
        return True

    run.session.run(1.5, pace=0.5, on_tick=take)
    assert begun == pytest.approx([100.0, 100.5, 101.0, 101.5, 102.0, 102.5])
    assert time.slept == pytest.approx([0.4] * 5)


def test_after_a_long_delay_a_run_does_not_catch_up(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))

    def stumble(session: SessionCore) -> bool:
        time.now += 10.0 if session.clock.frame == 2 else 0.0
        return True

    run.session.run(2.0, pace=1.0, on_tick=stumble)
    assert time.slept == pytest.approx(
        [0.25] * 5
    )  # after the stumble one tick runs at once, and the count begins there


def test_after_a_short_delay_a_run_catches_up() -> None:
    pacer = Pacer(0.25)
    pacer.begin()
    due = pacer.early()
    for _ in range(4):
        pacer.count()
    assert 0.9 < pacer.early() - due <= 1.0


def test_a_change_of_pace_restarts_the_schedule(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))

    def change(session: SessionCore) -> bool:
        if session.clock.frame == 2:
            session.pace = 0.1
        return True

    run.session.run(1.25, pace=1.0, on_tick=change)
    assert time.slept == pytest.approx([0.25, 2.5, 2.5])


# Pauses


def test_with_a_queue_a_paused_run_sleeps_and_continues_at_play(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    queue = run.session.queue = ScriptedQueue(time, lambda _: None, lambda _: None, SessionCore.play)
    run.session.run(0.5, paused=True)
    assert queue.waits == [IDLE] * 3
    assert run.lines() == ["Show 0.25", "Show 0.5"]


def test_the_length_of_a_run_is_simulation_time_across_stops(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    run.session.queue = queue = ScriptedQueue(time, SessionCore.play)

    def stop(session: SessionCore) -> bool:
        if session.ticks == 2:
            session.stop()
        return True

    run.session.run(1.0, on_tick=stop)
    assert queue.waits == [IDLE]
    assert [line for line in run.lines() if line.startswith("Show")] == ["Show 0.25", "Show 0.5"] * 2
    assert run.session.ticks == 4


def test_a_pause_restarts_the_schedule_of_ticks(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))

    def later(session: SessionCore) -> None:
        time.now += 100.0
        session.play()

    run.session.queue = queue = ScriptedQueue(time, SessionCore.pause, later)
    run.session.run(1.0, pace=1.0)
    assert queue.waits == pytest.approx([0.25, IDLE, 0.25, 0.25])


def test_commands_between_two_ticks_do_not_start_the_next_tick_early(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    run.session.queue = queue = ScriptedQueue(time, lambda _: None, lambda _: None)
    run.session.run(0.5, pace=1.0)
    assert queue.waits == pytest.approx([0.25] * 3)
    assert time.now == pytest.approx(100.25)


def test_single_ticks_of_a_paced_run_wait_only_for_camera_images(play: MakePlay, time: Time) -> None:
    run, realtime = play(SHOWS_TIME, tick_period=(1, 4)), []

    def look(session: SessionCore) -> bool:
        realtime.append(session.services.world.realtime)
        return True

    run.session.queue = ScriptedQueue(time, lambda session: session.advance(3), SessionCore.play)
    run.session.run(1.0, pace=1.0, on_tick=look, paused=True)
    assert realtime == [False, False, False, False, False, True]  # two sleeps, three single ticks, one of the play
    assert time.now == 100.0


def test_a_playing_session_refuses_single_ticks(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.play()
    with pytest.raises(StateError, match="pause it"):
        run.session.advance(1)


# The end


def test_an_interrupted_run_ends_at_any_point_and_can_run_again(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    run.session.queue = ScriptedQueue(time, SessionCore.interrupt)
    run.session.run(paused=True)
    assert run.session.ticks == 0
    run.session.run(1.0)
    assert run.session.ticks == 4


def test_after_an_interrupt_no_tick_begins(play: MakePlay, time: Time) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    run.session.queue = queue = ScriptedQueue(time)
    queue.ask(SessionCore.interrupt)
    run.session.run()
    assert run.session.ticks == 0


def test_an_interrupt_before_the_run_ends_the_run(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.interrupt()
    run.session.run()
    assert run.session.ticks == 0


def test_the_end_of_a_with_block_closes_the_queue(play: MakePlay, time: Time) -> None:
    with play(SHOWS_TIME).session as session:
        session.queue = queue = ScriptedQueue(time)
    with pytest.raises(StateError, match="the run has ended"):
        queue.submit("pause").result(0)
