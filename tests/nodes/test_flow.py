"""OnPhysicsStep, IsaacSimulationGate and OgnIsaacRunOneSimulationFrame."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.core.flow import IsaacSimulationGate, OgnIsaacRunOneSimulationFrame, OnPhysicsStep
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, ready

# OnPhysicsStep


def stepping(context: RecordingContext) -> OnPhysicsStep:
    context.runs = "physics_step"
    return ready(OnPhysicsStep, context)


def test_the_simulation_event_gives_the_duration_of_a_step(context: RecordingContext) -> None:
    node = stepping(context)
    node.compute()
    assert (node.kind(), node.delta_simulation_time) == ("event", 1 / 60)


def test_the_first_step_of_a_tick_gets_the_wall_time_of_the_whole_tick(context: RecordingContext) -> None:
    node, deltas = stepping(context), []
    for tick in range(3):
        context.clock.wall_time = 100.0 + 0.5 * tick
        for _ in range(4):
            node.compute()
            deltas.append(node.delta_system_time)
    assert deltas == [0.0] * 4 + [0.5, 0.0, 0.0, 0.0] * 2


def test_delta_system_time_is_zero_in_the_first_execution_after_a_stop(context: RecordingContext) -> None:
    node = stepping(context)
    node.compute()
    context.stop(node)
    context.clock.wall_time = 1000.0
    node.compute()
    assert node.delta_system_time == 0.0


def test_on_physics_step_in_a_graph_of_ticks_is_an_error_with_a_remedy(play: Player) -> None:
    text = "nodes: {Step: OnPhysicsStep, Clock: PublishClock}\nconnections: [Step.step -> Clock.execIn]"
    with pytest.raises(CheckError, match="this graph runs once a tick") as caught:
        play.graph(text)
    assert "write `runs: physics_step` into the graph file, or use OnPlaybackTick" in str(caught.value)


def test_a_graph_of_physics_steps_runs_at_each_step_with_the_time_of_the_step(play: Player) -> None:
    playing = play.graph(
        """
        runs: physics_step
        nodes: {Step: OnPhysicsStep, Time: ReadSimulationTime, Clock: PublishClock}
        connections: [Step.step -> Clock.execIn, Time.simulationTime -> Clock.timeStamp]
        """,
        RecordingWorld((1, 10), substeps=5),
    ).tick(2)
    stamps = [message.clock.nanosec for message in playing.published("/clock")]
    assert stamps == [number * 20_000_000 for number in range(1, 11)]
    assert playing.node("Step").delta_simulation_time == 0.02


# IsaacSimulationGate


@pytest.mark.parametrize(
    ("step", "fired"), [(1, list(range(1, 13))), (2, [2, 4, 6, 8, 10, 12]), (5, [5, 10]), (13, []), (0, [])]
)
def test_a_gate_fires_at_every_nth_execution_and_with_0_never(step: int, fired: list[int]) -> None:
    node = IsaacSimulationGate(step=step)
    assert [count for count in range(1, 13) if node.compute() == node.exec_out] == fired


def test_a_gate_of_1_is_the_default() -> None:
    node = IsaacSimulationGate()
    assert node.compute() == node.exec_out


def test_a_gate_counts_from_play() -> None:
    node = IsaacSimulationGate(step=2)
    node.compute()
    RecordingContext().stop(node)
    assert [node.compute(), node.compute()] == [None, node.exec_out]


def test_a_step_takes_effect_when_it_is_set() -> None:
    node = IsaacSimulationGate(step=0)
    for _ in range(3):
        node.compute()
    node.step = 4
    assert node.compute() == node.exec_out


def test_in_a_graph_each_firing_wire_counts_as_an_execution(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Other: OnPlaybackTick, Gate: {type: SimulationGate, inputs: {step: 3}}, Clock: PublishClock}
        connections: [Tick.tick -> Gate.execIn, Other.tick -> Gate.execIn, Gate.execOut -> Clock.execIn]
        """
    )
    assert playing.each_tick(6, lambda: len(playing.published("/clock"))) == [0, 1, 2, 2, 3, 4]


# OgnIsaacRunOneSimulationFrame


def test_one_frame_fires_at_its_first_execution_only_and_again_after_a_stop() -> None:
    context, node = RecordingContext(), OgnIsaacRunOneSimulationFrame()
    assert [node.compute() for _ in range(3)] == [node.step, None, None]
    context.stop(node)
    assert node.compute() == node.step


@pytest.mark.parametrize("pauses", [False, True])
def test_in_a_graph_one_frame_fires_once_a_play(play: Player, pauses: bool) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Once: OgnIsaacRunOneSimulationFrame, Clock: PublishClock}
        connections: [Tick.tick -> Once.execIn, Once.step -> Clock.execIn]
        """
    ).tick(3)
    if pauses:
        playing.session.pause()
        playing.session.play()
    playing.tick(2)
    assert len(playing.published("/clock")) == 1
    playing.session.stop()
    playing.tick(3)
    assert len(playing.published("/clock")) == 3  # one by the stop, which announces time 0
