"""OnPlaybackTick and OnTick."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.node.clock import Clock
from graphengine.nodes.action.events import OnPlaybackTick, OnTick
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, ready


def outputs(node: OnPlaybackTick) -> tuple[float, float, float]:
    return node.frame, node.delta_seconds, node.time


def test_on_playback_tick_is_an_event_whose_outputs_are_0_before_play() -> None:
    assert OnPlaybackTick.kind() == "event"
    assert outputs(OnPlaybackTick()) == (0.0, 0.0, 0.0)


def test_the_first_tick_is_frame_1_at_one_period(context: RecordingContext) -> None:
    node = ready(OnPlaybackTick, context)
    context.tick()
    node.compute()
    assert outputs(node) == (1.0, 1 / 60, 1 / 60)


@given(frame=st.integers(1, 10**9), rate=st.integers(1, 1000), denominator=st.integers(1, 1001))
def test_time_is_the_frame_times_the_period_without_accumulated_rounding(
    frame: int, rate: int, denominator: int
) -> None:
    context = RecordingContext()
    context.clock = Clock((denominator, rate))
    node = ready(OnPlaybackTick, context)
    context.clock.set_frame(frame)
    node.compute()
    assert node.time == float(Fraction(frame * denominator, rate))


def test_a_stop_resets_the_outputs_and_play_counts_from_1_again(context: RecordingContext) -> None:
    node = ready(OnPlaybackTick, context)
    context.tick(7)
    node.compute()
    context.stop(node)
    assert outputs(node) == (0.0, 0.0, 0.0)
    context.tick()
    node.compute()
    assert outputs(node) == (1.0, 1 / 60, 1 / 60)


def test_in_a_graph_on_playback_tick_fires_once_a_tick_for_any_number_of_substeps(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Clock: PublishClock}
        connections: [Tick.tick -> Clock.execIn, Tick.time -> Clock.timeStamp]
        """,
        RecordingWorld((1, 4), substeps=5),
    ).tick(3)
    assert [(m.clock.sec, m.clock.nanosec) for m in playing.published("/clock")] == [
        (0, 250_000_000),
        (0, 500_000_000),
        (0, 750_000_000),
    ]


def test_on_playback_tick_in_a_graph_of_physics_steps_is_an_error_with_a_remedy(play: Player) -> None:
    text = "runs: physics_step\nnodes: {Tick: OnPlaybackTick, C: PublishClock}\nconnections: [Tick.tick -> C.execIn]"
    with pytest.raises(CheckError, match="this graph runs at every physics step") as caught:
        play.graph(text)
    assert "use OnPhysicsStep, or write `runs: tick` into the graph file" in str(caught.value)


def test_while_stopped_or_paused_nothing_fires(play: Player) -> None:
    playing = play.graph("nodes: {Tick: OnPlaybackTick, C: PublishClock}\nconnections: [Tick.tick -> C.execIn]")
    playing.session.play()
    playing.session.pause()
    assert playing.published("/clock") == []


# OnTick


@pytest.mark.parametrize(("period", "frames"), [(0, [1, 2, 3, 4, 5, 6]), (1, [1, 3, 5]), (2, [1, 4]), (9, [1])])
def test_on_tick_fires_in_the_first_tick_and_then_skips_frame_period_ticks(period: int, frames: list[int]) -> None:
    context, fired = RecordingContext(), list[int]()
    node = ready(OnTick, context, frame_period=period)
    for _ in range(2):
        for _ in range(6):
            context.tick()
            fired += [int(node.frame)] if node.compute() == node.tick else []
        context.stop(node)
        assert (node.frame, node.delta_seconds, node.is_playing) == (0.0, 0.0, False)
    assert fired == frames * 2


def test_delta_seconds_includes_the_skipped_ticks(context: RecordingContext) -> None:
    node = ready(OnTick, context, frame_period=2)
    deltas = []
    for _ in range(4):
        context.tick()
        deltas += [node.delta_seconds] if node.compute() == node.tick else []
    assert deltas == pytest.approx([1 / 60, 3 / 60])
    assert (node.time, node.absolute_sim_time, node.is_playing) == (4 / 60, 4 / 60, True)


def test_in_a_graph_on_tick_with_a_period_fires_first_in_the_first_tick(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: {type: OnTick, inputs: {framePeriod: 3}}, C: PublishClock}
        connections: [Tick.tick -> C.execIn, Tick.frame -> C.timeStamp]
        """
    ).tick(10)
    assert [message.clock.sec for message in playing.published("/clock")] == [1, 5, 9]
