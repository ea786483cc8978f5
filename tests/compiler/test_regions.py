"""What an event or a pusher runs (R2, R3)."""

from __future__ import annotations

from tests.compiler.conftest import MakeBench

# R2: events


def test_r2_events_fire_at_the_start_of_a_pass_in_the_order_of_the_file(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Second: Every, First: Every, A: Do, B: Do}
        connections:
          - First.fired -> A.execIn
          - Second.fired -> B.execIn
    """)
    run["First"].n = run["Second"].n = 1
    assert [run.graph.instances[call.node].id for call in run.plan.root.calls] == ["Second", "First", "A", "B"]
    assert run.tick() == ["A 0", "B 0"]


def test_r2_a_gated_event_that_does_not_fire_runs_nothing(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Every: {type: Every, inputs: {n: 3}}, A: Do}
        connections: [Every.fired -> A.execIn]
    """)
    assert run.ticks(6) == [[], [], ["A 0"], [], [], ["A 0"]]


def test_r2_an_event_with_two_outputs_fires_the_one_it_returns(bench: MakeBench) -> None:
    run = bench("""
        nodes: {TwoEnds: TwoEnds, Even: Do, Odd: Do}
        connections:
          - TwoEnds.even -> Even.execIn
          - TwoEnds.odd -> Odd.execIn
    """)
    assert run.ticks(3) == [["Odd 0"], ["Even 0"], ["Odd 0"]]


# R3: regions


def test_r3_a_node_below_two_ports_of_a_pusher_runs_for_each(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, A: Do, Shared: Do}
        connections:
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> Shared.execIn
          - Sequence.b -> A.execIn
          - Sequence.c -> Shared.execIn
    """)
    assert run.tick() == ["Shared 0", "A 0", "Shared 0"]


def test_r3_the_tail_that_two_ports_share_runs_in_both_regions(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, A: Do, B: Do, Shared: Do, End: Do}
        connections:
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> A.execIn
          - Sequence.b -> B.execIn
          - A.execOut -> Shared.execIn
          - B.execOut -> Shared.execIn
          - Shared.execOut -> End.execIn
    """)
    assert run.tick() == ["A 0", "Shared 0", "End 0", "B 0", "Shared 0", "End 0"]


def test_r3_a_node_reached_from_an_event_and_from_a_pusher_runs_for_both(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, Join: Join}
        connections:
          - Tick.tick -> Join.first
          - Tick.tick -> Sequence.execIn
          - Sequence.b -> Join.second
    """)
    assert run.tick() == ["Join first=1 second=0 hold=0", "Join first=0 second=1 hold=0"]
    assert run.tick() == ["Join first=1 second=0 hold=0", "Join first=0 second=1 hold=0"]


def test_r3_what_fired_in_one_region_is_not_seen_by_a_run_of_the_node_in_another(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, Join: Join, Late: Do}
        connections:
          - Tick.tick -> Join.first
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> Join.second
          - Sequence.b -> Late.execIn
          - Late.sum -> Join.value
    """)
    # Join reads from Late, so it runs for the tick after the sequence, although the tick fires it before.
    assert run.tick() == ["Join first=0 second=1 hold=0", "Late 0", "Join first=1 second=0 hold=0"]


def test_r3_a_pusher_below_a_branch_runs_only_when_the_branch_is_taken(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Branch: Branch, Sequence: Sequence, A: Do, B: Do}
        connections:
          - Tick.tick -> Branch.execIn
          - Branch.execTrue -> Sequence.execIn
          - Sequence.a -> A.execIn
          - Sequence.b -> B.execIn
    """)
    assert run.tick() == ["Branch False"]
    run["Branch"].condition = True
    assert run.tick() == ["Branch True", "A 0", "B 0"]


def test_r3_a_branch_below_a_pusher_is_decided_anew_in_each_run_of_the_region(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Less: {type: Less, inputs: {b: 1.5}}, Branch: Branch, Low: Do, High: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Branch.execIn
          - ForLoop.index -> Less.a
          - Less.result -> Branch.condition
          - Branch.execTrue -> Low.execIn
          - Branch.execFalse -> High.execIn
    """)
    assert run.tick() == ["Branch True", "Low 0", "Branch True", "Low 0", "Branch False", "High 0"]


def test_r3_pushers_nest(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Outer: {type: ForLoop, inputs: {stop: 2}}, Inner: {type: ForLoop, inputs: {stop: 2}}, A: Do, B: Do}
        connections:
          - Tick.tick -> Outer.execIn
          - Outer.loopBody -> Inner.execIn
          - Inner.loopBody -> A.execIn
          - Outer.index -> A.a
          - Inner.index -> A.b
          - Inner.finished -> B.execIn
    """)
    assert run.tick() == ["A 0", "A 1", "B 0", "A 1", "A 2", "B 0"]


def test_r3_a_yield_of_several_ports_runs_their_regions_in_order(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Both: Both, A: Do, B: Do}
        connections:
          - Tick.tick -> Both.execIn
          - Both.b -> B.execIn
          - Both.a -> A.execIn
          - Both.index -> A.a
          - Both.index -> B.a
    """)
    assert run.tick() == ["A 0", "B 0", "A 1", "B 1"]


def test_r3_two_pushers_share_a_third(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, One: Sequence, Two: Sequence, Inner: ForLoop, A: Do}
        connections:
          - Tick.tick -> One.execIn
          - Tick.tick -> Two.execIn
          - One.a -> Inner.execIn
          - Two.c -> Inner.execIn
          - Inner.loopBody -> A.execIn
          - Inner.index -> A.a
    """)
    assert run.tick() == ["A 0", "A 1", "A 2"] * 2
