"""Delay, Timer, Countdown and custom events: alone, and in graphs."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.nodes.action.custom import OnCustomEvent, SendCustomEvent
from graphengine.nodes.action.waiting import Countdown, Delay, Timer
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, Playing, computed, ready

# Later


LATER = """
nodes:
  Tick: OnPlaybackTick
  Start: Once
  Wait: {node}
  Done: Counter
connections:
  - Tick.tick -> Start.execIn
  - Start.once -> Wait.execIn
  - Wait.finished -> Done.execIn
"""


def ticks_until_done(playing: Playing, limit: int = 100) -> int:
    for tick in range(1, limit):
        playing.tick()
        if playing.node("Done").count:
            return tick
    raise AssertionError(f"nothing within {limit} ticks")


@pytest.mark.parametrize(
    ("duration", "ticks"), [(0.0, 1), (0.01, 1), (1 / 60, 1), (0.05, 3), (0.1, 6), (0.5, 30), (0.51, 31)]
)
def test_a_delay_fires_in_the_first_tick_at_or_after_its_time(play: Player, duration: float, ticks: int) -> None:
    playing = play.graph(LATER.format(node=f"{{type: Delay, inputs: {{duration: {duration!r}}}}}"))
    assert ticks_until_done(playing) == 1 + ticks


def test_an_execution_restarts_a_delay(context: RecordingContext) -> None:
    node = ready(Delay, context, duration=0.1)
    for _ in range(20):
        context.tick()
        node.compute()
        assert node.update() is None
    ticks = 0
    while node.active:
        context.tick()
        ticks += 1
        node.update()
    assert ticks == 5  # its output is executed in the pass after


def passes(node: Timer, context: RecordingContext, limit: int = 100) -> list[tuple[str, float]]:
    """What it fires in the passes after it was executed, with its value."""
    fired = list[tuple[str, float]]()
    while node.active and len(fired) < limit:
        ports = node.update()
        fired.append(({node.updated: "updated", node.finished: "finished"}[ports or 0], node.value))
        context.tick()
    return fired


def test_a_timer_moves_a_value_from_one_end_to_the_other(context: RecordingContext) -> None:
    node = ready(Timer, context, duration=4 / 60, start_value=10.0, end_value=-10.0)
    context.tick()
    node.compute()
    moved = [("updated", pytest.approx(value)) for value in (10.0, 5.0, 0.0, -5.0, -10.0)]
    assert passes(node, context) == [*moved, ("finished", -10.0)]
    node.compute()
    assert len(passes(node, context)) == 6
    context.stop(node)
    assert (node.value, node.active) == (0.0, False)


def test_an_execution_during_the_motion_does_not_restart_a_timer(context: RecordingContext) -> None:
    node = computed(Timer, context, duration=0.1)
    before = node.update(), node.update()
    node.compute()
    assert before == (node.updated, node.updated)
    assert node.value == 0.0
    context.tick(6)
    assert (node.update(), node.value) == (node.updated, 1.0)


@pytest.mark.parametrize("duration", [0.0, -1.0])
def test_a_timer_without_a_duration_is_at_its_end_at_once(duration: float, context: RecordingContext) -> None:
    node = computed(Timer, context, duration=duration, end_value=3.0)
    assert passes(node, context) == [("updated", 3.0), ("finished", 3.0)]


def test_a_timer_in_a_graph_updates_once_a_tick_and_finishes_in_the_next(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Start: Once
          Move: {type: Timer, inputs: {duration: 0.05, endValue: 6.0}}
          Moved: Counter
          Clock: PublishClock
          Done: Counter
        connections:
          - Tick.tick -> Start.execIn
          - Start.once -> Move.play
          - Move.updated -> Moved.execIn
          - Moved.execOut -> Clock.execIn
          - Move.value -> Clock.timeStamp
          - Move.finished -> Done.execIn
        """
    )
    assert ticks_until_done(playing) == 6  # executed in tick 1, at 0, 1/3, 2/3 and the whole way in 2 to 5
    assert [message.clock.sec for message in playing.published("/clock")] == [0, 2, 4, 6]
    assert playing.node("Moved").count == 4


def test_a_countdown_fires_every_period_and_at_its_end() -> None:
    node: Any = Countdown(duration=5, period=2)
    seen = []
    node.compute()
    while node.active:
        ports = node.update()
        seen.append((node.tick_value, node.alpha, bool(ports & node.tick), bool(ports & node.finished)))
    assert seen == [
        (1, 0.2, False, False),
        (2, 0.4, True, False),
        (3, 0.6, False, False),
        (4, 0.8, True, False),
        (5, 1.0, False, True),
    ]
    assert node.count == -1


def test_an_execution_restarts_a_countdown_at_0() -> None:
    node: Any = Countdown(duration=4)
    node.compute()
    for _ in range(3):
        node.update()
    assert (node.tick_value, node.alpha) == (3, 0.75)
    node.compute()
    assert (node.tick_value, node.alpha, node.count) == (0, 0.0, 0)


@pytest.mark.parametrize("period", [0, -2])
def test_a_period_of_0_counts_as_1(period: int) -> None:
    node: Any = Countdown(duration=2)
    node.period = period
    node.compute()
    assert [node.update() & node.tick for _ in range(2)] == [node.tick, node.tick]


def test_a_countdown_in_a_graph_ticks_once_a_tick(play: Player) -> None:
    text = LATER.format(node="{type: Countdown, inputs: {duration: 4}}").replace("Done:", "Ticks: Counter\n  Done:")
    playing = play.graph(f"{text}  - Wait.tick -> Ticks.execIn\n")
    assert ticks_until_done(playing) == 5
    assert playing.node("Ticks").count == 4


# Custom events


def test_every_sent_event_is_received_once_in_the_next_tick_with_its_path(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Loop: {type: ForLoop, inputs: {stop: 3}}
          Send: {type: SendCustomEvent, inputs: {eventName: bump, path: /here}}
          Hear: {type: OnCustomEvent, inputs: {eventName: bump}}
          Other: {type: OnCustomEvent, inputs: {eventName: another}}
          Heard: Counter
          Wrong: Counter
        connections:
          - Tick.tick -> Loop.execIn
          - Loop.loopBody -> Send.execIn
          - Hear.execOut -> Heard.execIn
          - Other.execOut -> Wrong.execIn
        """
    )
    assert playing.each_tick(3, lambda: playing.node("Heard").count) == [0, 3, 6]
    assert (playing.node("Hear").path, playing.node("Wrong").count) == ("/here", 0)


def test_an_event_is_sent_from_node_to_node(context: RecordingContext) -> None:
    sender = ready(SendCustomEvent, context, event_name="e", path="p")
    listener = ready(OnCustomEvent, context, event_name="e")
    sender.compute()
    assert list(listener.compute()) == []
    context.tick()
    assert list(listener.compute()) == [listener.exec_out]
    assert listener.path == "p"
