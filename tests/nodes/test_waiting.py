"""Delay, Countdown and custom events: alone, and in graphs."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.testing import RecordingContext
from nodes.action.custom import OnCustomEvent, SendCustomEvent
from nodes.action.waiting import Countdown, Delay
from tests.nodes.harness import Player, Playing, ready

# Later


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
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Start: Once
          Wait: {{type: Delay, inputs: {{duration: {duration!r}}}}}
          Done: Counter
        connections:
          - Tick.tick -> Start.execIn
          - Start.once -> Wait.execIn
          - Wait.finished -> Done.execIn
        """
    )
    assert ticks_until_done(playing) == 1 + ticks


def test_a_delay_that_is_executed_again_waits_anew() -> None:
    context = RecordingContext()
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


def test_a_countdown_in_a_graph_ticks_once_a_tick(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Start: Once
          Down: {type: Countdown, inputs: {duration: 4}}
          Ticks: Counter
          Done: Counter
        connections:
          - Tick.tick -> Start.execIn
          - Start.once -> Down.execIn
          - Down.tick -> Ticks.execIn
          - Down.finished -> Done.execIn
        """
    )
    assert ticks_until_done(playing) == 5
    assert playing.node("Ticks").count == 4


# Custom events


def test_every_event_sent_is_seen_once_in_the_next_tick_with_its_path(play: Player) -> None:
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
    counts = []
    for _ in range(3):
        playing.tick()
        counts.append(playing.node("Heard").count)
    assert counts == [0, 3, 6]
    assert (playing.node("Hear").path, playing.node("Wrong").count) == ("/here", 0)


def test_an_event_goes_from_node_to_node() -> None:
    context = RecordingContext()
    sender = ready(SendCustomEvent, context, event_name="e", path="p")
    listener = ready(OnCustomEvent, context, event_name="e")
    sender.compute()
    assert list(listener.compute()) == []
    context.tick()
    assert list(listener.compute()) == [listener.exec_out]
    assert listener.path == "p"
