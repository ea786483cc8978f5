"""The facts that people see of a run, by a wall clock that only the test moves."""

from __future__ import annotations

import pytest

from graphengine.node.dropped_values import DroppedValues
from graphengine.runtime.run_status import StatusMeter
from tests.compiler.conftest import MakePlay
from tests.runtime.test_run import SHOWS_TIME, Time


@pytest.fixture
def time(monkeypatch: pytest.MonkeyPatch) -> Time:
    return Time(monkeypatch)


def test_rates_cover_the_last_second(play: MakePlay, time: Time) -> None:
    session = play(SHOWS_TIME, tick_period=(1, 10)).session
    meter = StatusMeter(session)
    factors = []
    for ticks in (10, 5, 5, 0, 0):
        session.run(ticks / 10)
        session.services.network.sent += 3 * ticks
        time.now += 0.5
        status = meter.read()
        factors.append((status.real_time_factor, status.message_rate))
    assert factors == [pytest.approx(pair) for pair in [(2.0, 60.0), (1.5, 45.0), (1.0, 30.0), (0.5, 15.0), (0.0, 0.0)]]


def test_a_reading_after_a_long_time_covers_the_whole_time(play: MakePlay, time: Time) -> None:
    session = play(SHOWS_TIME, tick_period=(1, 10)).session
    meter = StatusMeter(session)
    session.run(2.0)
    time.now += 10.0
    assert meter.read().real_time_factor == pytest.approx(0.2)


def test_two_readings_at_the_same_time_have_rates_of_zero(play: MakePlay, time: Time) -> None:
    meter = StatusMeter(play(SHOWS_TIME).session)
    status = meter.read()
    assert (status.real_time_factor, status.message_rate, status.tick_cpu) == (0.0, 0.0, 0.0)


def test_a_tick_that_ends_after_the_next_one_was_due_is_late(play: MakePlay, time: Time) -> None:
    session = play(SHOWS_TIME, tick_period=(1, 4)).session
    lasts = iter([0.1, 0.3, 0.1, 10.0, 0.2, 0.1])

    step = session._tick

    def slow() -> None:
        step()
        time.now += next(lasts)

    session._tick = slow  # type: ignore[method-assign]
    session.run(1.5, pace=1.0)
    assert session.late_ticks == 2
    assert StatusMeter(session).read().late_ticks == 2


def test_a_run_without_a_pace_has_no_late_ticks(play: MakePlay, time: Time) -> None:
    session = play(SHOWS_TIME).session
    session.run(1.0)
    assert StatusMeter(session).read().late_ticks == 0


def test_the_status_has_dropped_values_and_the_state(play: MakePlay) -> None:
    session = play(SHOWS_TIME, tick_period=(1, 4)).session
    dropped = session.services.dropped = DroppedValues()
    for node, tick in (("/a", 1), ("/a", 1), ("/a", 2), ("/b", 2)):
        dropped.add(node, tick)
    session.run(1.0)
    session.pause()
    status = StatusMeter(session).read()
    assert (status.dropped_values, status.state, status.time, status.tick) == (3, "paused", 1.0, 4)
    assert (status.pace, status.recorded_bytes, status.subscribers) == (None, None, 0)
