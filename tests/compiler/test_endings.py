"""What starts between ticks: the pass at the end of a play, and that before a graph is closed."""

from __future__ import annotations

import pytest

from graphengine.format.errors import NodeError
from tests.compiler.conftest import MakeBench, MakePlay
from tests.compiler.harness import Play

STOP = "{type: omni.graph.action.OnStageEvent, inputs: {eventName: Simulation Stop Play}}"
ENDS = f"""
    nodes: {{Tick: Tick, Each: Do, Stop: {STOP}, Stopped: Do, Closing: omni.graph.action.OnClosing, Closed: Do}}
    connections:
      - Tick.tick -> Each.execIn
      - Stop.execOut -> Stopped.execIn
      - Tick.time -> Stopped.a
      - Closing.execOut -> Closed.execIn
"""
RAISES = f"""
    nodes: {{Stop: {STOP}, Raise: Raise, After: Do}}
    connections:
      - Stop.execOut -> Raise.execIn
      - Raise.execOut -> After.execIn
"""


def after(run: Play) -> list[str]:
    return [line for line in run.lines() if not line.startswith("Each")]


def test_at_an_ending_only_nodes_below_its_event_run(bench: MakeBench) -> None:
    run = bench(ENDS)
    assert run.tick() == ["Each 0"]
    run.executor.run_ending("at_stop")
    assert run.journal.read() == ["Stopped 0.01"]
    run.executor.run_ending("at_close")
    assert run.journal.read() == ["Closed 0"]


def test_a_stop_ends_a_play_once_with_what_its_last_tick_left_before_anything_is_reset(play: MakePlay) -> None:
    run, reset = play(ENDS, tick_period=(1, 4)), ["zero commands", "reset state", "reset time"]
    run.session.step(3)
    run.session.stop()
    assert after(run) == ["Stopped 0.75", *reset]
    run.session.stop()
    assert after(run) == reset
    run.session.step(2)
    run.session.stop()
    assert after(run) == ["Stopped 0.5", *reset]


def test_a_reset_of_the_time_ends_a_play_and_one_of_the_state_does_not(play: MakePlay) -> None:
    run = play(ENDS, tick_period=(1, 4))
    run.session.step(3)
    run.session.reset("state")
    assert after(run) == ["reset state"]
    run.session.reset("time")
    assert after(run) == ["Stopped 0.75", "zero commands", "reset time"]


def test_a_pause_ends_no_play(play: MakePlay) -> None:
    run = play(ENDS)
    run.session.run(0.1)
    run.session.pause()
    run.session.play()
    assert after(run) == []


def test_a_session_that_ends_stops_its_play_and_then_closes_its_graphs_once(play: MakePlay) -> None:
    run = play(ENDS, tick_period=(1, 4))
    run.session.step()
    run.session.end()
    assert after(run) == ["Stopped 0.25", "Closed 0"]
    run.session.close()
    run.session.close()
    assert "Closed 0" not in after(run)


def test_a_session_that_never_played_only_closes_its_graphs(play: MakePlay) -> None:
    run = play(ENDS)
    run.session.close()
    assert [line for line in after(run) if line.startswith(("Stopped", "Closed"))] == ["Closed 0"]


def test_volatile_data_nodes_are_computed_again_at_an_ending(bench: MakeBench) -> None:
    run = bench(f"""
        nodes: {{Tick: Tick, Each: Do, Ticket: Ticket, Stop: {STOP}, Stopped: Do}}
        connections:
          - Tick.tick -> Each.execIn
          - Stop.execOut -> Stopped.execIn
          - Ticket.number -> Each.a
          - Ticket.number -> Stopped.a
    """)
    assert run.ticks(2) == [["Each 1"], ["Each 2"]]
    run.executor.run_ending("at_stop")
    assert run.journal.read() == ["Stopped 3"]


def test_a_loop_at_an_ending_runs_all_its_iterations(bench: MakeBench) -> None:
    run = bench(f"""
        nodes: {{Stop: {STOP}, Loop: {{type: ForLoop, inputs: {{stop: 3}}}}, Body: Do}}
        connections:
          - Stop.execOut -> Loop.execIn
          - Loop.loopBody -> Body.execIn
    """)
    run.tick()
    run.executor.run_ending("at_stop")
    assert run.journal.read() == ["Body 0"] * 3


def test_firings_of_latent_nodes_before_an_ending_wait_for_the_next_tick(bench: MakeBench) -> None:
    run = bench(f"""
        nodes: {{Go: {{type: Every, inputs: {{n: 2}}}}, Later: {{type: Stages, inputs: {{plan: '1'}}}}, Do: Do, Stop: {STOP}}}
        connections:
          - Go.fired -> Later.execIn
          - Later.first -> Do.execIn
          - Stop.execOut -> Do.execIn
    """)
    lines = run.ticks(2)
    run.executor.run_ending("at_stop")
    assert [*lines, run.journal.read(), run.tick()] == [[], [], ["Do 0"], ["Do 0"]]


def test_a_node_that_raises_at_an_ending_is_reported_and_the_other_nodes_run(play: MakePlay) -> None:
    run = play(RAISES, ENDS)
    told: list[str] = []
    run.services.log = lambda severity, node, message: told.append(f"{severity}: {message}")
    run.session.step()
    run.session.stop()
    assert (run.session.state, run.session.time) == ("stopped", 0.0)
    assert [line for line in after(run) if line.startswith(("Stopped", "After"))] == ["Stopped 0.0166667"]
    (message,) = told
    assert message.startswith("error: ")
    assert "node Raise (test.Raise) raised" in message


def test_after_an_error_a_session_ends_without_its_graphs_until_it_begins_anew(play: MakePlay) -> None:
    run = play(
        ENDS.replace("Closed: Do", "Closed: Do, Raise: {type: Raise, inputs: {at: 2.0}}")
        + "      - Tick.tick -> Raise.execIn\n"
    )
    run.session.step()
    with pytest.raises(NodeError):
        run.session.step()
    run.session.end()
    assert after(run) == ["zero commands"]
    run.session.reset()
    run.session.step()
    run.session.end()
    assert after(run)[-1] == "Closed 0"


def test_a_push_graph_has_no_ends(bench: MakeBench) -> None:
    run = bench("    evaluator: push\n" + ENDS)
    run.tick()
    run.executor.run_ending("at_stop")
    run.executor.run_ending("at_close")
    assert run.journal.read() == []


@pytest.mark.parametrize("ending", ["at_stop", "at_close"])
def test_a_graph_without_events_for_an_ending_runs_no_nodes(bench: MakeBench, ending: str) -> None:
    run = bench("    nodes: {Tick: Tick, Each: Do}\n    connections: [Tick.tick -> Each.execIn]\n")
    run.tick()
    run.executor.run_ending(ending)  # type: ignore[arg-type]
    assert run.journal.read() == []
