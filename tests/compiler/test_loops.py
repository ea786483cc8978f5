"""R11: loops and how they are left; R6: control pins of pushers; R13: one region run for each message."""

from __future__ import annotations

import pytest

from graphengine.format.errors import NodeError
from tests.compiler.conftest import MakeBench
from tests.compiler.nodes_for_tests.pushers import ForLoop


def test_r11_each_iteration_completes_its_body_and_then_finished_fires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, A: Do, B: Do, End: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.finished -> End.execIn
          - ForLoop.loopBody -> A.execIn
          - A.execOut -> B.execIn
          - ForLoop.index -> A.a
    """)
    assert run.tick() == ["A 0", "B 0", "A 1", "B 0", "A 2", "B 0", "End 0"]


def test_r11_a_loop_without_iterations_only_finishes(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: {type: ForLoop, inputs: {stop: 0}}, A: Do, End: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
          - ForLoop.finished -> End.execIn
    """)
    assert run.tick() == ["End 0"]


def test_r11_break_acts_at_the_end_of_the_body(bench: MakeBench) -> None:
    run = bench("""
        nodes:
          Tick: Tick
          ForLoop: {type: ForLoop, inputs: {stop: 5}}
          Less: {type: Less, inputs: {a: 0.5}}
          Branch: Branch
          Stop: Do
          Rest: Do
          End: Do
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Branch.execIn
          - ForLoop.loopBody -> Rest.execIn
          - ForLoop.index -> Less.b
          - Less.result -> Branch.condition
          - Branch.execTrue -> Stop.execIn
          - Stop.execOut -> ForLoop.breakLoop
          - ForLoop.finished -> End.execIn
    """)
    once = ["Branch False", "Rest 0", "Branch True", "Rest 0", "Stop 0", "ForLoop breaks", "End 0"]
    assert run.ticks(2) == [once, once]  # the break of the last pass is forgotten


def test_r6_a_break_wired_straight_from_the_body_port_acts(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
          - ForLoop.loopBody -> ForLoop.breakLoop
    """)
    assert run.ticks(2) == [["A 0", "ForLoop breaks"]] * 2


def test_r6_a_break_wired_from_a_sequence_inside_of_the_body_acts(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Sequence: Sequence, A: Do, B: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Sequence.execIn
          - Sequence.a -> A.execIn
          - Sequence.b -> ForLoop.breakLoop
          - Sequence.c -> B.execIn
    """)
    assert run.ticks(2) == [["A 0", "B 0", "ForLoop breaks"]] * 2


def test_r6_a_break_of_the_outer_loop_leaves_the_inner_one_alone(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Outer: ForLoop, Inner: {type: ForLoop, inputs: {stop: 2}}, A: Do, End: Do}
        connections:
          - Tick.tick -> Outer.execIn
          - Outer.loopBody -> Inner.execIn
          - Inner.loopBody -> A.execIn
          - A.execOut -> Outer.breakLoop
          - Outer.finished -> End.execIn
    """)
    assert run.ticks(2) == [["A 0", "A 0", "Outer breaks", "End 0"]] * 2


def test_r6_a_break_that_nobody_is_in_a_loop_to_hear_ends_the_next_loop_at_once(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, A: Do, ForLoop: ForLoop, B: Do}
        connections:
          - Tick.tick -> A.execIn
          - A.execOut -> ForLoop.breakLoop
          - A.execOut -> ForLoop.execIn
          - ForLoop.loopBody -> B.execIn
    """)
    assert run.ticks(2) == [["A 0", "B 0", "ForLoop breaks"]] * 2


def test_r13_an_event_that_pushes_runs_its_region_once_for_each_message(bench: MakeBench) -> None:
    run = bench("""
        nodes: {OnMessage: OnMessage, Twice: Double, A: Do, B: Do, End: Do}
        connections:
          - OnMessage.received -> A.execIn
          - A.execOut -> B.execIn
          - OnMessage.value -> A.a
          - OnMessage.value -> Twice.number
          - Twice.value -> B.a
          - OnMessage.done -> End.execIn
    """)
    box = run.services.queues["messages"]
    assert run.tick() == ["End 0"]
    box.post(1.0)
    box.post(2.0)
    assert run.tick() == ["A 1", "B 2", "A 2", "B 4", "End 0"]
    assert run.tick() == ["End 0"]


def test_r13_plain_events_beside_a_pushing_one_fire_as_ever(bench: MakeBench) -> None:
    run = bench("""
        nodes: {OnMessage: OnMessage, Tick: Tick, A: Do, B: Do}
        connections:
          - Tick.tick -> B.execIn
          - OnMessage.received -> A.execIn
          - OnMessage.value -> A.a
          - A.sum -> B.a
    """)
    run.services.queues["messages"].post(4.0)
    assert run.tick() == ["A 4", "B 4"]
    assert run.tick() == ["B 4"]


def test_r11_a_loop_without_end_is_a_clear_error(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: {type: ForLoop, inputs: {stop: 100001}}, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
    """)
    with pytest.raises(NodeError, match=r"ForLoop .* ran on after 100000 iterations"):
        run.tick()


def test_r11_the_bound_is_that_of_the_node_type(bench: MakeBench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ForLoop, "max_pushes", 4)  # three iterations and finished
    run = bench("""
        nodes: {Tick: Tick, ForLoop: {type: ForLoop, inputs: {stop: 3}}, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
    """)
    assert run.tick() == ["A 0", "A 0", "A 0"]
    run["ForLoop"].stop = 4
    with pytest.raises(NodeError, match="after 4 iterations"):
        run.tick()
