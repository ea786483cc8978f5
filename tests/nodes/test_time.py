"""IsaacReadSimulationTime, IsaacReadSystemTime, their annotators, IsaacTimeSplitter and IsaacRealTimeFactor."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages import messages
from graphengine.nodes.core.time import (
    IsaacReadSimulationTime,
    IsaacReadSimulationTimeAnnotator,
    IsaacReadSystemTime,
    IsaacReadSystemTimeAnnotator,
    IsaacRealTimeFactor,
    IsaacTimeSplitter,
)
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, computed, ready


@pytest.mark.parametrize(
    ("inputs", "plays", "expected"),
    [
        pytest.param({}, [90], 1.5, id="counts from play"),
        pytest.param({}, [90, 30], 0.5, id="counts from play again after a stop"),
        pytest.param({"reset_on_stop": False}, [90, 30], 2.0, id="goes on over stop and play without resetOnStop"),
        pytest.param(
            {"reference_time_numerator": 7, "reference_time_denominator": 4}, [90], 1.75, id="is the reference"
        ),
        pytest.param(
            {"reference_time_numerator": 7}, [60], 1.0, id="is the clock's if the reference lacks a denominator"
        ),
    ],
)
def test_simulation_time_counts_from_play_or_from_the_start_of_the_session(
    inputs: dict[str, Any], plays: list[int], expected: float, context: RecordingContext
) -> None:
    node = ready(IsaacReadSimulationTime, context, **inputs)
    for ticks in plays:
        context.stop(node)
        assert node.simulation_time == 0.0
        context.tick(ticks)
        node.compute()
    assert node.simulation_time == expected


def test_a_changed_reset_on_stop_takes_effect(context: RecordingContext) -> None:
    node = ready(IsaacReadSimulationTime, context)
    context.tick(90)
    context.stop(node)
    context.tick(30)
    node.compute()
    node.reset_on_stop = False
    node.compute()
    assert node.simulation_time == 2.0


# IsaacReadSystemTime


def test_system_time_is_the_wall_time_at_the_start_of_the_tick(context: RecordingContext) -> None:
    node = ready(IsaacReadSystemTime, context)
    assert node.system_time == 0.0
    context.clock.wall_time = 1.7e9
    node.compute()
    assert node.system_time == 1.7e9


def test_a_reference_time_overrides_the_wall_clock() -> None:
    node = computed(IsaacReadSystemTime, RecordingContext(), reference_time_numerator=7, reference_time_denominator=4)
    assert node.system_time == 1.75


# Annotators


@pytest.mark.parametrize("cls", [IsaacReadSimulationTimeAnnotator, IsaacReadSystemTimeAnnotator])
def test_an_annotator_is_executed_and_fires(cls: Any) -> None:
    assert (cls.kind(), cls.gated) == ("action", False)


def test_an_annotator_reads_simulation_time_when_it_is_executed(context: RecordingContext) -> None:
    node = ready(IsaacReadSimulationTimeAnnotator, context, reset_on_stop=False)
    context.tick(30)
    context.stop(node)
    context.tick(30)
    node.compute()
    assert node.simulation_time == 1.0


@pytest.mark.parametrize("kind", ["simulation", "system"])
def test_all_nodes_read_the_same_time_in_a_tick(play: Player, kind: str) -> None:
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Time: IsaacRead{kind.title()}Time
          Read: IsaacRead{kind.title()}TimeAnnotator
          One: {{type: PublishClock, inputs: {{topicName: one}}}}
          Other: {{type: PublishClock, inputs: {{topicName: other}}}}
        connections:
          - Tick.tick -> One.execIn
          - Tick.tick -> Read.execIn
          - Read.execOut -> Other.execIn
          - Time.{kind}Time -> One.timeStamp
          - Read.{kind}Time -> Other.timeStamp
        """,
        RecordingWorld((1, 10)),
    ).tick(3)
    one, other = (
        [m.clock.sec + m.clock.nanosec / 1e9 for m in playing.published(topic)] for topic in ("/one", "/other")
    )
    assert one == other
    assert len(one) == 3
    assert one == [0.1, 0.2, 0.3] if kind == "simulation" else min(one) > 1e9


# IsaacTimeSplitter


def split(time: Any) -> tuple[int, int, int, int]:
    node = IsaacTimeSplitter(time=time)
    node.compute()
    return node.seconds, node.milliseconds, node.microseconds, node.nanoseconds


@given(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
def test_the_outputs_of_the_splitter_are_consistent_parts_of_the_time(seconds: int, nanoseconds: int) -> None:
    whole, ms, us, ns = split(seconds + nanoseconds / 1e9)
    assert abs(whole + ns / 1e9 - (seconds + nanoseconds / 1e9)) <= 1e-9 + 1e-15 * seconds
    assert (ms, us) == (ns // 1_000_000, ns // 1_000)
    assert 0 <= ns < 10**9


@given(st.floats(-1e6, 1e6))
def test_the_splitter_outputs_the_seconds_and_nanoseconds_of_the_stamp(time: float) -> None:
    seconds, _, _, nanoseconds = split(time)
    assert messages.stamp(time) == messages.Time(seconds, nanoseconds)


@given(st.integers(0, 2**31 - 1))
def test_a_whole_number_of_seconds_has_no_remainder(seconds: int) -> None:
    assert split(seconds) == (seconds, 0, 0, 0)


def test_in_a_graph_the_splitter_splits_a_wired_time(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Time: ReadSimulationTime, Split: TimeSplitter, Clock: PublishClock}
        connections:
          - Tick.tick -> Clock.execIn
          - Time.simulationTime -> Split.time
          - Split.milliseconds -> Clock.timeStamp
        """,
        RecordingWorld((1, 8)),
    ).tick(9)
    assert [message.clock.sec for message in playing.published("/clock")] == [125, 250, 375, 500, 625, 750, 875, 0, 125]


# IsaacRealTimeFactor


def factors(*wall_times: float, ticks: int = 1) -> list[float]:
    """What it reads in ticks that begin at these wall times."""
    context = RecordingContext()
    node, found = ready(IsaacRealTimeFactor, context), []
    for wall_time in wall_times:
        context.tick(ticks)
        context.clock.wall_time = wall_time
        node.compute()
        found.append(node.rtf)
    return found


def test_the_real_time_factor_is_simulation_time_divided_by_wall_time() -> None:
    assert factors(100.0, 100.5, 102.5, ticks=60) == pytest.approx([0.0, 2.0, 0.5])


def test_the_real_time_factor_is_kept_while_a_clock_stands_still_or_is_set_back() -> None:
    assert factors(100.0, 100.5, 100.5, 90.0, 91.0, ticks=60) == pytest.approx([0.0, 2.0, 2.0, 2.0, 1.0])


def test_in_ticks_of_several_steps_the_real_time_factor_is_computed_over_whole_ticks() -> None:
    # The wall clock is read once a tick; four steps of 1/60 s a tick, whose wall clock goes on by 1/15 s.
    walls = [10.0 + tick / 15 for tick in range(4) for _ in range(4)]
    assert factors(*walls)[4:] == pytest.approx([1.0] * 12)


def test_reading_twice_in_a_tick_changes_nothing(context: RecordingContext) -> None:
    node = ready(IsaacRealTimeFactor, context)
    for wall_time in (1.0, 1.5):
        context.tick(60)
        context.clock.wall_time = wall_time
        for _ in range(2):
            node.compute()
    assert node.rtf == pytest.approx(2.0)


def test_in_a_graph_a_stop_resets_the_annotator_and_the_real_time_factor(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Time: IsaacReadSimulationTimeAnnotator
          Factor: IsaacRealTimeFactor
          Fast: {type: Compare, inputs: {b: 0.0}}
          Once: Branch
        connections:
          - Tick.tick -> Time.execIn
          - Time.execOut -> Once.execIn
          - Factor.rtf -> Fast.a
          - Fast.result -> Once.condition
        """
    ).tick(3)
    assert playing.node("Time").simulation_time == 3 / 60
    assert playing.node("Factor").rtf > 0.0
    playing.session.stop()
    assert (playing.node("Time").simulation_time, playing.node("Factor").rtf) == (0.0, 0.0)
