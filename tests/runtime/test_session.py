"""R1, R2, R14, R15: what a tick is, and what play, pause, step, stop and reset do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graphengine.format.errors import ContextError, NodeError, PhysicsError
from graphengine.node.variable import Variable
from tests.compiler.conftest import MakePlay
from tests.compiler.harness import Play, write
from tests.other_process import in_another_process

SHOWS_TIME = """
    nodes: {Tick: Tick, Show: Do}
    connections:
      - Tick.tick -> Show.execIn
      - Tick.time -> Show.a
"""


# R1


def test_r1_a_tick_is_commands_and_substeps_then_graphs_in_order_then_latent_nodes(play: MakePlay) -> None:
    first = """
        nodes: {Tick: Tick, First: Do, Delay: {type: Delay, inputs: {duration: 0.0}}}
        connections:
          - Tick.tick -> First.execIn
          - Tick.tick -> Delay.execIn
    """
    second = """
        nodes: {Tick: Tick, Second: Do}
        connections: [Tick.tick -> Second.execIn]
    """
    run = play(first, second, substeps=2)
    run.session.step()
    assert run.journal.read() == ["step", "step", "begin 1", "First 0", "Second 0", "Delay ends"]
    assert run.journal.frozen == 1


def test_r1_physics_step_graphs_run_after_each_substep_with_the_time_of_the_substep(play: MakePlay) -> None:
    on_step = """
        runs: physics_step
        nodes: {Tick: Tick, Step: Do}
        connections:
          - Tick.tick -> Step.execIn
          - Tick.time -> Step.a
    """
    run = play(SHOWS_TIME, on_step, tick_period=(1, 4), substeps=2)
    run.session.step(2)
    assert run.journal.read() == [
        *("step", "Step 0.125", "step", "Step 0.25", "begin 1", "Show 0.25"),
        *("step", "Step 0.375", "step", "Step 0.5", "begin 2", "Show 0.5"),
    ]


def test_r1_latent_nodes_of_physics_step_graphs_are_updated_each_step(play: MakePlay) -> None:
    run = play(
        """
        runs: physics_step
        nodes: {Go: {type: Every, inputs: {n: 4}}, Delay: {type: Delay, inputs: {duration: 0.25}}, End: Do}
        connections:
          - Go.fired -> Delay.execIn
          - Delay.finished -> End.execIn
        """,
        tick_period=(1, 4),
        substeps=2,
    )
    assert [run.tick() for _ in range(4)] == [[], [], ["Delay ends"], ["End 0"]]


def test_r1_the_first_tick_is_at_dt(play: MakePlay) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 8))
    assert run.session.time == 0.0
    assert run.tick() == ["Show 0.125"]
    assert (run.session.time, run.clock.frame, run.clock.delta) == (0.125, 1, 0.125)


def test_r1_time_does_not_drift(play: MakePlay) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 60))
    for n in range(1, 10_001):
        run.clock.set_frame(n)
        assert run.clock.time == n / 60
    run.clock.set_frame(10_799)
    run.tick()
    assert run.session.time == 180.0


@pytest.mark.parametrize(("numerator", "denominator"), [(1, 1000), (1001, 30_000), (1, 3)])
def test_r1_time_is_the_number_of_the_tick_times_the_period(play: MakePlay, numerator: int, denominator: int) -> None:
    run = play(SHOWS_TIME, tick_period=(numerator, denominator))
    run.session.step(500)
    assert run.session.time == 500 * numerator / denominator


# R2: what is raised in one tick is seen in the next


POSTS = """
    nodes: {Go: {type: Every, inputs: {n: 1}}, Post: {type: Post, inputs: {value: 7.0, times: 2}}, Posted: Do}
    connections:
      - Go.fired -> Post.execIn
      - Post.execOut -> Posted.execIn
"""
RECEIVES = """
    nodes: {OnMessage: OnMessage, Received: Do}
    connections:
      - OnMessage.received -> Received.execIn
      - OnMessage.value -> Received.a
"""


@pytest.mark.parametrize("texts", [(POSTS, RECEIVES), (RECEIVES, POSTS)])
def test_r2_a_custom_event_is_seen_in_the_next_tick_whatever_the_order_of_graphs(
    play: MakePlay, texts: tuple[str, str]
) -> None:
    run = play(*texts)
    posting = run.node("Go", texts.index(POSTS))
    assert run.tick() == ["Posted 0"]
    posting.n = 1000
    assert run.tick() == ["Received 7", "Received 7"]
    assert run.tick() == []


def test_r2_every_graph_that_listens_hears_an_event(play: MakePlay) -> None:
    run = play(RECEIVES, POSTS, RECEIVES)
    run.tick()
    run.node("Go", 1).n = 1000
    assert run.tick() == ["Received 7"] * 4


def test_r2_impulses_coalesce(play: MakePlay) -> None:
    run = play(
        """
        nodes: {OnImpulse: {type: OnImpulse, inputs: {name: messages}}, Done: Do}
        connections: [OnImpulse.fired -> Done.execIn]
        """,
        POSTS,
    )
    assert run.tick() == ["Posted 0"]
    run.node("Go", 1).n = 1000
    assert run.tick() == ["Done 0"]
    assert run.tick() == []


def test_r2_an_event_that_raises_itself_does_so_once_a_tick(play: MakePlay) -> None:
    run = play("""
        nodes: {OnMessage: OnMessage, Again: Post, Received: Do}
        connections:
          - OnMessage.received -> Again.execIn
          - Again.execOut -> Received.execIn
    """)
    run.services.queues["messages"].post(0.0)
    assert [run.tick() for _ in range(3)] == [["Received 0"]] * 3


def test_r2_more_than_1000_events_in_a_tick_are_an_error_that_names_the_node(play: MakePlay) -> None:
    run = play(POSTS)
    run.node("Post").times = 1000
    run.tick()
    run.node("Post").times = 1001
    with pytest.raises(NodeError, match=r"node Post .*more than 1000 events 'messages' in one tick") as caught:
        run.tick()
    assert isinstance(caught.value.__cause__, ContextError)


def test_r2_what_is_posted_in_a_physics_step_is_seen_in_the_next_tick_only(play: MakePlay) -> None:
    run = play("runs: physics_step\n" + POSTS.replace("\n    ", "\n"), RECEIVES, substeps=2)
    run.node("Go").n = 2
    assert run.tick() == ["Posted 0"]
    run.node("Go").n = 1000
    assert run.tick() == ["Received 7", "Received 7"]


def test_r2_a_change_of_a_variable_is_seen_in_the_next_tick(play: MakePlay) -> None:
    run = play("""
        variables: {speed: {type: double}}
        nodes: {Tick: Tick, Write: WriteVariable}
        connections:
          - Tick.tick -> Write.execIn
          - Tick.number -> Write.value
    """)
    variable = run.session.graphs[0].variables["speed"]
    changed = []
    for _ in range(3):
        run.session.step()
        changed.append(variable.changed)
    assert changed == [False, True, True]


def test_a_changed_array_in_a_variable_is_detected() -> None:
    variable = Variable(np.zeros(3))
    variable.freeze()
    assert not variable.changed
    variable.value = np.zeros(2)
    variable.freeze()
    assert variable.changed


# R14


RAISES = """
    nodes:
      Tick: Tick
      Before: Do
      Raise: {type: Raise, inputs: {at: 2.0, label: some text}}
      After: Do
    connections:
      - Tick.tick -> Before.execIn
      - Before.execOut -> Raise.execIn
      - Raise.execOut -> After.execIn
"""


def test_r14_a_node_that_raises_stops_the_run_after_commands_were_zeroed(play: MakePlay) -> None:
    run = play(RAISES)
    assert run.tick() == ["Before 0", "After 0"]
    with pytest.raises(NodeError) as caught:
        run.session.run(10.0)
    assert run.lines() == ["Before 0", "zero commands"]
    assert run.session.state == "failed"
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert run.journal.logged == [f"error: {caught.value}"]


def test_r14_the_error_names_node_file_line_type_inputs_tick_and_time(play: MakePlay) -> None:
    run = play(RAISES, tick_period=(1, 4))
    run.tick()
    with pytest.raises(NodeError) as caught:
        run.tick()
    where, when, inputs = str(caught.value).split("\n")
    assert where.endswith("g0.yaml:5:3: node Raise (test.Raise) raised ZeroDivisionError: it was to be expected")
    assert when == "  at tick 2, 0.5 s, in graph g0"
    assert inputs == "  inputs: at=2.0, label='some text'"


def test_r14_a_simulation_that_diverges_stops_the_run_too(play: MakePlay, monkeypatch: pytest.MonkeyPatch) -> None:
    run = play(SHOWS_TIME)

    def diverge() -> None:
        raise PhysicsError("not finite")

    monkeypatch.setattr(run.world, "step", diverge)
    with pytest.raises(PhysicsError):
        run.tick()
    assert run.lines() == ["zero commands"]


def test_r14_pins_that_an_aborted_pass_left_are_forgotten_on_stop(play: MakePlay) -> None:
    run = play("""
        nodes: {Tick: Tick, Join: Join, Raise: {type: Raise, inputs: {at: 2.0}}, After: Do}
        connections:
          - Tick.tick -> Raise.execIn
          - Raise.execOut -> Join.second
          - Tick.tick -> Join.first
          - Join.execOut -> After.execIn
          - After.execOut -> Join.hold
    """)
    first = run.tick()
    with pytest.raises(NodeError):
        run.tick()
    run.session.stop()
    run.lines()
    assert first == run.tick() == ["Join first=1 second=1 hold=0", "After 0"]


# R15 as far as it is the session's: samples are counted in ticks


def test_r15_the_world_is_told_the_number_of_each_tick_and_of_the_first_after_stop_again(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.step(2)
    run.session.stop()
    run.session.step()
    assert [line for line in run.journal.read() if line.startswith("begin")] == ["begin 1", "begin 2", "begin 1"]


# Play, pause, step, stop, reset


EVERYTHING = """
    variables: {speed: {type: double, default: 1.0}}
    nodes:
      Tick: Tick
      Join: Join
      Counter: Counter
      Gate: Gate
      Delay: {type: Delay, inputs: {duration: 0.03}}
      End: Do
      Read: ReadVariable
      Add: {type: Add, inputs: {b: 1.0}}
      Write: WriteVariable
      Dice: Dice
      Post: Post
      OnMessage: OnMessage
      Received: Do
      Ticket: Ticket
      Constant: {type: Add, inputs: {a: 1.0}}
      Show: Do
    connections:
      - Tick.tick -> Join.first
      - Join.execOut -> Counter.execIn
      - Counter.execOut -> Join.hold
      - Tick.tick -> Counter.second
      - Tick.tick -> Gate.enter
      - Tick.tick -> Gate.toggle
      - Gate.exit -> Delay.execIn
      - Delay.finished -> End.execIn
      - Counter.count -> End.a
      - Tick.tick -> Write.execIn
      - Read.value -> Add.a
      - Add.sum -> Write.value
      - Tick.tick -> Dice.execIn
      - Gate.exit -> Post.execIn
      - OnMessage.received -> Received.execIn
      - Tick.tick -> Show.execIn
      - Ticket.number -> Show.a
      - Constant.sum -> Show.b
"""


def one_play(run: Play) -> list[str]:
    run.session.step(7)
    return run.lines()


def test_a_second_play_equals_the_first(play: MakePlay) -> None:
    run = play(EVERYTHING)
    first = one_play(run)
    run.session.stop()
    run.lines()
    assert len(first) > 30
    assert one_play(run) == first


def play_everything(folder: Path) -> list[str]:
    return one_play(Play(write(folder, EVERYTHING)))


def test_two_processes_with_the_same_files_and_seed_give_equal_results(tmp_path: Path) -> None:
    assert in_another_process(play_everything, tmp_path) == play_everything(tmp_path)


def test_stop_puts_outputs_and_state_back_to_their_defaults(play: MakePlay) -> None:
    run = play(EVERYTHING)
    run.session.step(3)
    run.session.stop()
    assert (run.node("Counter").count, run.node("Gate").open, run.node("Delay").active) == (0.0, False, False)
    assert (run.node("Tick").number, run.node("Tick").time) == (0.0, 0.0)
    assert run.session.graphs[0].variables["speed"].value == 1.0
    assert run.session.time == 0.0
    assert run.lines()[-3:] == ["zero commands", "reset state", "reset time"]


def test_stop_restores_the_outputs_of_setup(play: MakePlay) -> None:
    run = play("""
        nodes: {Tick: Tick, Show: Show, Announce: {type: Announce, inputs: {topic: scan}}}
        connections:
          - Tick.tick -> Show.execIn
          - Show.execOut -> Announce.execIn
          - Announce.opened -> Show.value
    """)
    first = run.tick()
    run.session.stop()
    run.lines()
    assert first == run.tick() == ["Show /scan", "Announce sends on /scan"]


def test_monotonic_time_continues_after_stop_and_play(play: MakePlay) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 4))
    run.session.step(3)
    run.session.stop()
    run.session.step(2)
    assert (run.clock.time, run.clock.monotonic_time) == (0.5, 1.25)


def test_pause_holds_a_run_and_step_runs_single_ticks(play: MakePlay) -> None:
    run = play(SHOWS_TIME)

    def pause_at_3(session: object) -> bool:
        if run.clock.frame == 3:
            run.session.pause()
        return True

    run.session.run(1.0, on_tick=pause_at_3)
    assert (run.session.state, run.clock.frame) == ("paused", 3)
    run.session.step(2)
    assert (run.session.state, run.clock.frame) == ("paused", 5)


def test_step_of_a_stopped_session_pauses_it(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.step()
    assert run.session.state == "paused"


def test_pause_of_a_stopped_session_changes_nothing(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.pause()
    assert run.session.state == "stopped"


def test_run_plays_as_many_ticks_as_the_seconds_hold(play: MakePlay) -> None:
    run = play(SHOWS_TIME, tick_period=(1, 60))
    run.session.run(2.0)
    assert (run.clock.frame, run.session.time) == (120, 2.0)
    run.session.run(0.5)
    assert run.clock.frame == 150


def test_stop_ends_a_run_without_a_queue(play: MakePlay) -> None:
    run = play(SHOWS_TIME)

    def stop_at_3(session: object) -> bool:
        if run.clock.frame == 3:
            run.session.stop()
        return True

    run.session.run(1.0, on_tick=stop_at_3)
    assert (run.session.state, run.clock.frame) == ("stopped", 0)


def test_on_tick_can_end_a_run_without_a_stop(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.run(1.0, on_tick=lambda session: session.clock.frame < 4)
    assert (run.session.state, run.clock.frame) == ("playing", 4)


def test_reset_restarts_the_session_in_its_state(play: MakePlay) -> None:
    run = play(SHOWS_TIME)
    run.session.run(0.5)
    run.session.reset()
    assert (run.session.state, run.clock.frame) == ("playing", 0)


def test_the_end_of_a_with_block_closes_world_and_network(play: MakePlay) -> None:
    with play(SHOWS_TIME).session as session:
        session.step()
    assert session.services.world.closed == 1  # type: ignore[attr-defined]
