"""IsaacReadSimulationTime and OgnIsaacRunOneSimulationFrame."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.testing import RecordingContext, RecordingWorld
from nodes.core.time import IsaacReadSimulationTime, OgnIsaacRunOneSimulationFrame
from tests.nodes.harness import Player


def reading(context: RecordingContext, **inputs: Any) -> IsaacReadSimulationTime:
    node = IsaacReadSimulationTime(**inputs)
    node.setup(context)
    return node


def test_simulation_time_is_0_before_it_is_read() -> None:
    assert IsaacReadSimulationTime().simulation_time == 0.0


def test_simulation_time_counts_from_play() -> None:
    context = RecordingContext()
    node = reading(context)
    context.tick(90)
    node.compute()
    assert node.simulation_time == 1.5


def test_simulation_time_counts_from_play_again_after_a_stop() -> None:
    context = RecordingContext()
    node = reading(context)
    context.tick(90)
    node.compute()
    context.stop(node)
    assert node.simulation_time == 0.0
    context.tick(30)
    node.compute()
    assert node.simulation_time == 0.5


def test_without_reset_on_stop_simulation_time_goes_on_over_stop_and_play() -> None:
    context = RecordingContext()
    node = reading(context, reset_on_stop=False)
    context.tick(90)
    context.stop(node)
    context.tick(30)
    node.compute()
    assert node.simulation_time == 2.0


def test_reset_on_stop_acts_when_it_is_set() -> None:
    context = RecordingContext()
    node = reading(context)
    context.tick(90)
    context.stop(node)
    context.tick(30)
    node.compute()
    node.reset_on_stop = False
    node.compute()
    assert node.simulation_time == 2.0


def test_a_reference_time_overrides_the_clock() -> None:
    context = RecordingContext()
    node = reading(context, reference_time_numerator=7, reference_time_denominator=4)
    context.tick(90)
    node.compute()
    assert node.simulation_time == 1.75


def test_a_reference_time_without_denominator_is_the_clock() -> None:
    context = RecordingContext()
    node = reading(context, reference_time_numerator=7)
    context.tick(60)
    node.compute()
    assert node.simulation_time == 1.0


def test_everything_that_reads_simulation_time_in_a_tick_reads_the_same(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Time: IsaacReadSimulationTime
          One: {type: PublishClock, inputs: {topicName: one}}
          Other: {type: PublishClock, inputs: {topicName: other}}
        connections:
          - Tick.tick -> One.execIn
          - Tick.tick -> Other.execIn
          - Time.simulationTime -> One.timeStamp
          - Time.simulationTime -> Other.timeStamp
        """,
        RecordingWorld((1, 10)),
    )
    playing.tick(3)
    one, other = ([m.clock.nanosec for m in playing.published(topic)] for topic in ("/one", "/other"))
    assert one == other == [100_000_000, 200_000_000, 300_000_000]


def test_one_frame_fires_at_its_first_execution_only() -> None:
    node = OgnIsaacRunOneSimulationFrame()
    assert [node.compute() for _ in range(3)] == [node.step, None, None]


def test_one_frame_fires_again_after_a_stop() -> None:
    context, node = RecordingContext(), OgnIsaacRunOneSimulationFrame()
    node.compute()
    context.stop(node)
    assert node.compute() == node.step


@pytest.mark.parametrize("pauses", [False, True])
def test_in_a_graph_one_frame_fires_once_a_play(play: Player, pauses: bool) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Once: OgnIsaacRunOneSimulationFrame, Clock: PublishClock}
        connections: [Tick.tick -> Once.execIn, Once.step -> Clock.execIn]
        """
    )
    playing.tick(3)
    if pauses:
        playing.session.pause()
        playing.session.play()
    playing.tick(2)
    assert len(playing.published("/clock")) == 1
    playing.session.stop()
    playing.tick(3)
    assert len(playing.published("/clock")) == 2
