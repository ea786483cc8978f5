"""In which order nodes run, and what wins where execution and data disagree (R4, R5)."""

from __future__ import annotations

from tests.compiler.conftest import MakeBench

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
        "First.a reads the value that Second had before this pass, because execution orders First before Second"
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
        "First.a reads the value that Inside had before this pass, because execution orders First before Inside"
    )
