"""R2 to R7: what runs in a pass, in which order, how often."""

from __future__ import annotations

from tests.engine.conftest import MakeBench

# R2: events


def test_r2_events_fire_at_the_start_of_a_pass_in_the_order_of_the_file(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Second: Every, First: Every, A: Do, B: Do}
        connections:
          - First.fired -> A.execIn
          - Second.fired -> B.execIn
    """)
    run["First"].n = run["Second"].n = 1
    assert [run.plan.graph.instances[call.node].id for call in run.plan.root.calls] == ["Second", "First", "A", "B"]
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


# R4: order in a region


def test_r4_a_node_runs_after_every_node_it_reads_from_even_if_wired_later(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Reader: Do, Source: {type: Do, inputs: {a: 7.0}}}
        connections:
          - Tick.tick -> Reader.execIn
          - Tick.tick -> Source.execIn
          - Source.sum -> Reader.a
    """)
    assert run.tick() == ["Source 7", "Reader 7"]


def test_r4_a_node_runs_after_what_it_reads_through_data_nodes(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Reader: Do, Source: {type: Do, inputs: {a: 7.0}}, One: Add, Two: Double}
        connections:
          - Tick.tick -> Reader.execIn
          - Tick.tick -> Source.execIn
          - Source.sum -> One.b
          - One.sum -> Two.number
          - Two.value -> Reader.b
    """)
    assert run.tick() == ["Source 7", "Reader 14"]


def test_r4_siblings_run_in_the_order_of_their_first_wires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, A: Do, B: Do, C: Do}
        connections:
          - Tick.tick -> C.execIn
          - Tick.tick -> A.execIn
          - Tick.tick -> B.execIn
    """)
    assert run.tick() == ["C 0", "A 0", "B 0"]


def test_r4_a_node_with_several_incoming_wires_runs_once_after_all_of_them(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Join: Join, A: Do, B: Do, C: Do}
        connections:
          - A.execOut -> Join.first
          - B.execOut -> Join.first
          - C.execOut -> Join.second
          - Tick.tick -> A.execIn
          - Tick.tick -> B.execIn
          - Tick.tick -> C.execIn
    """)
    assert run.tick() == ["A 0", "B 0", "C 0", "Join first=2 second=1 hold=0"]
    assert run.tick()[-1] == "Join first=2 second=1 hold=0"


def test_r4_branches_merge_into_one_run_whichever_was_taken(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Branch: Branch, Yes: Do, No: Do, Merge: Join}
        connections:
          - Tick.tick -> Branch.execIn
          - Branch.execTrue -> Yes.execIn
          - Branch.execFalse -> No.execIn
          - Yes.execOut -> Merge.first
          - No.execOut -> Merge.second
    """)
    assert run.tick() == ["Branch False", "No 0", "Merge first=0 second=1 hold=0"]
    run["Branch"].condition = True
    assert run.tick() == ["Branch True", "Yes 0", "Merge first=1 second=0 hold=0"]


def test_r4_a_pusher_with_its_regions_is_one_unit_that_readers_come_after(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Reader: Do, Sequence: Sequence, A: {type: Do, inputs: {a: 3.0}}, B: Do}
        connections:
          - Tick.tick -> Reader.execIn
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> A.execIn
          - Sequence.c -> B.execIn
          - A.sum -> Reader.a
    """)
    assert run.tick() == ["A 3", "B 0", "Reader 3"]


def test_r4_a_pusher_comes_after_what_anything_below_it_reads(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, A: Do, B: Do, Source: {type: Do, inputs: {a: 3.0}}}
        connections:
          - Tick.tick -> Sequence.execIn
          - Tick.tick -> Source.execIn
          - Sequence.a -> A.execIn
          - Sequence.b -> B.execIn
          - Source.sum -> B.a
    """)
    assert run.tick() == ["Source 3", "A 0", "B 3"]


def test_only_the_wired_output_of_a_branch_is_followed(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Branch: Branch, Yes: Do}
        connections:
          - Tick.tick -> Branch.execIn
          - Branch.execTrue -> Yes.execIn
    """)
    assert run.tick() == ["Branch False"]
    run["Branch"].condition = True
    assert run.tick() == ["Branch True", "Yes 0"]


def test_an_action_may_fire_both_of_its_outputs_or_none(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Choose: Choose, A: Do, B: Do}
        connections:
          - Tick.tick -> Choose.execIn
          - Choose.first -> A.execIn
          - Choose.second -> B.execIn
    """)
    seen = []
    for bits in range(4):
        run["Choose"].bits = bits
        seen.append(run.tick())
    assert seen == [[], ["A 0"], ["B 0"], ["A 0", "B 0"]]


def test_r14_an_action_that_fires_nothing_ends_that_branch_only(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: Door, A: Do, B: Do, C: Do}
        connections:
          - Tick.tick -> Door.execIn
          - Door.execOut -> A.execIn
          - A.execOut -> B.execIn
          - Tick.tick -> C.execIn
    """)
    assert run.tick() == ["A 0", "B 0", "C 0"]
    run["Door"].open = False
    assert run.tick() == ["C 0"]


# R5: conflicts


def test_r5_execution_wins_over_data_and_the_dropped_wire_is_named(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, First: Do, Second: {type: Do, inputs: {a: 1.0}}}
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Second.execIn
          - Second.sum -> First.a
          - First.sum -> Second.b
    """)
    assert run.codes == ["W104"]
    assert run.message("W104") == (
        "First.a reads the value that Second had before this pass: execution orders First before it"
    )
    assert str(run.findings.items[0].span).endswith("g.yaml:6:5")
    assert run.ticks(3) == [["First 0", "Second 1"], ["First 1", "Second 2"], ["First 2", "Second 3"]]


def test_r5_feedback_through_a_data_node_reads_the_previous_value(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, First: Do, Second: {type: Do, inputs: {a: 1.0}}, Plus: {type: Add, inputs: {b: 10.0}}}
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Second.execIn
          - Second.sum -> Plus.a
          - Plus.sum -> First.a
          - First.sum -> Second.b
    """)
    assert run.codes == ["W104"]
    assert run.ticks(2) == [["First 10", "Second 11"], ["First 21", "Second 22"]]


def test_r5_a_node_that_reads_itself_reads_what_it_gave_before(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sum: {type: Do, inputs: {b: 1.0}}}
        connections:
          - Tick.tick -> Sum.execIn
          - Sum.sum -> Sum.a
    """)
    assert run.codes == []
    assert run.ticks(3) == [["Sum 1"], ["Sum 2"], ["Sum 3"]]


def test_r5_the_order_of_a_sequence_wins_over_a_data_wire(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Sequence: Sequence, Reader: Do, Source: {type: Do, inputs: {a: 5.0}}}
        connections:
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> Reader.execIn
          - Sequence.b -> Source.execIn
          - Source.sum -> Reader.a
    """)
    assert run.message("W104").startswith("Reader.a reads the value that Source had before this pass")
    assert run.ticks(2) == [["Reader 0", "Source 5"], ["Reader 5", "Source 5"]]


def test_r5_of_two_siblings_that_read_each_other_the_later_wire_is_dropped(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, A: {type: Do, inputs: {b: 1.0}}, B: {type: Do, inputs: {b: 1.0}}}
        connections:
          - Tick.tick -> A.execIn
          - Tick.tick -> B.execIn
          - B.sum -> A.a
          - A.sum -> B.a
    """)
    assert run.message("W104").startswith("B.a reads the value that A had before this pass")
    assert run.ticks(2) == [["B 1", "A 2"], ["B 3", "A 4"]]


def test_r5_a_wire_into_a_region_names_the_node_it_comes_from_and_not_the_pusher(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, First: Do, Sequence: Sequence, Inside: {type: Do, inputs: {a: 5.0}}}
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Sequence.execIn
          - Sequence.a -> Inside.execIn
          - Inside.sum -> First.a
    """)
    assert run.message("W104") == (
        "First.a reads the value that Inside had before this pass: execution orders First before it"
    )


# R6: control pins


def test_r6_a_control_pin_acts_before_the_pins_that_fire_with_it(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Gate: Gate, A: Do}
        connections:
          - Tick.tick -> Gate.enter
          - Tick.tick -> Gate.toggle
          - Gate.exit -> A.execIn
    """)
    assert run.ticks(3) == [["Gate opens", "A 0"], ["Gate closes"], ["Gate opens", "A 0"]]


def test_r6_a_control_wire_that_closes_a_cycle_acts_for_the_next_activation(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Gate: Gate, A: Do}
        connections:
          - Tick.tick -> Gate.enter
          - Gate.exit -> A.execIn
          - A.execOut -> Gate.toggle
    """)
    run["Gate"].open = True
    assert run.codes == []
    assert run.ticks(3) == [["A 0"], ["Gate closes"], []]


def test_r6_an_ordinary_node_sees_its_pending_control_pin_once(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Every: {type: Every, inputs: {n: 1}}, Join: Join, Door: Door}
        connections:
          - Every.fired -> Join.first
          - Join.execOut -> Door.execIn
          - Door.execOut -> Join.hold
    """)
    assert run.tick() == ["Join first=1 second=0 hold=0"]
    run["Door"].open = False
    assert run.tick() == ["Join first=1 second=0 hold=1"]
    assert run.tick() == ["Join first=1 second=0 hold=0"]


def test_r6_a_pending_control_pin_waits_for_an_activation(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: Door, Join: Join, After: Do}
        connections:
          - Tick.tick -> Door.execIn
          - Door.execOut -> Join.second
          - Join.execOut -> After.execIn
          - After.execOut -> Join.hold
    """)
    assert run.tick()[0] == "Join first=0 second=1 hold=0"
    run["Door"].open = False
    assert run.ticks(2) == [[], []]
    run["Door"].open = True
    assert run.tick()[0] == "Join first=0 second=1 hold=1"


# R7: counts


def test_r7_an_ordinary_node_computes_once_and_sees_how_often_it_was_fired(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Join: Join}
        connections:
          - One.tick -> Join.first
          - Two.tick -> Join.first
          - Two.tick -> Join.second
    """)
    assert run.ticks(2) == [["Join first=2 second=1 hold=0"]] * 2


def test_r7_a_node_that_counts_computes_once_for_each_activation_in_order_of_wires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter}
        connections:
          - Two.tick -> Counter.second
          - One.tick -> Counter.execIn
    """)
    assert run.ticks(2) == [
        ["Counter in=0 second=1 reset=0 count=1", "Counter in=1 second=0 reset=0 count=2"],
        ["Counter in=0 second=1 reset=0 count=3", "Counter in=1 second=0 reset=0 count=4"],
    ]


def test_r7_control_activations_come_first_whatever_the_order_of_wires(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.reset
    """)
    once = ["Counter in=0 second=0 reset=1 count=0", "Counter in=1 second=0 reset=0 count=1"]
    assert run.ticks(2) == [once, once]


def test_r7_a_counting_node_counts_the_activations_of_a_counting_node(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, First: Counter, Second: Counter}
        connections:
          - One.tick -> First.execIn
          - Two.tick -> First.execIn
          - First.execOut -> Second.execIn
          - Two.tick -> Second.second
    """)
    assert run.tick()[-1] == "Second in=0 second=1 reset=0 count=3"
    assert run["Second"].count == 3.0


def test_r7_activations_of_untaken_branches_do_not_count(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: {type: Door, inputs: {open: false}}, Counter: Counter}
        connections:
          - Tick.tick -> Counter.execIn
          - Tick.tick -> Door.execIn
          - Door.execOut -> Counter.second
    """)
    assert run.ticks(2) == [
        ["Counter in=1 second=0 reset=0 count=1"],
        ["Counter in=1 second=0 reset=0 count=2"],
    ]


def test_r7_a_counting_node_in_a_loop_counts_iterations(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Counter: Counter, Show: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Counter.execIn
          - ForLoop.finished -> Show.execIn
          - Counter.count -> Show.a
          - Tick.tick -> Counter.second
    """)
    run.tick()
    assert run["Counter"].count == 4.0


def test_r7_each_activation_sees_data_that_the_one_before_changed(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter, Next: {type: Add, inputs: {b: 1.0}}}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.second
          - Counter.count -> Next.a
          - Next.sum -> Counter.step
    """)
    run.tick()
    assert run["Counter"].count == 3.0  # 0 + (0 + 1), then 1 + (1 + 1)


def test_r7_a_node_sees_how_often_a_counting_node_fired_its_only_wire(bench: MakeBench) -> None:
    run = bench("""
        nodes: {One: Tick, Two: Tick, Counter: Counter, Second: Counter, Join: Join}
        connections:
          - One.tick -> Counter.execIn
          - Two.tick -> Counter.second
          - Counter.execOut -> Second.execIn
          - Counter.execOut -> Join.first
    """)
    run.tick()
    assert run["Second"].count == 2.0
    assert run.tick()[-1] == "Join first=2 second=0 hold=0"
