"""R8 to R10: data nodes are computed when something they show has changed, and only then."""

from __future__ import annotations

import pytest

from tests.compiler.conftest import MakeBench
from tests.compiler.harness import Bench


def computes_of(run: Bench, node_id: str) -> int:
    """How often a data node was computed since this was last asked."""
    node = run[node_id]
    count, node.computes = node.computes, 0
    return int(count)


# R8


def test_r8_a_constant_is_computed_once_before_the_first_pass(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Add: {type: Add, inputs: {a: 1.0, b: 2.0}}, Show: Do, Other: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.tick -> Other.execIn
          - Add.sum -> Show.a
          - Add.sum -> Other.a
    """)
    assert computes_of(run, "Add") == 1
    assert run.ticks(2) == [["Show 3", "Other 3"]] * 2
    assert computes_of(run, "Add") == 0


def test_r8_a_wire_from_an_input_carries_its_constant(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Constant: {type: Constant, inputs: {value: 4.0}}, Show: Do, Twin: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Constant.value -> Show.a
          - Tick.tick -> Twin.execIn
          - Show.inputs:a -> Twin.b
    """)
    assert run.tick() == ["Show 4", "Twin 4"]


def test_r8_two_consumers_share_one_compute(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Add: {type: Add, inputs: {b: 1.0}}, Show: Do, Other: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Show.execOut -> Other.execIn
          - Tick.number -> Add.a
          - Add.sum -> Show.a
          - Add.sum -> Other.a
    """)
    assert run.tick() == ["Show 2", "Other 2"]
    assert computes_of(run, "Add") == 1


def test_r8_a_source_that_computes_between_two_consumers_makes_the_second_see_the_new_value(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Add: {type: Add, inputs: {b: 1.0}}, Show: Do, Source: {type: Do, inputs: {a: 5.0}}, Other: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Show.execOut -> Source.execIn
          - Source.execOut -> Other.execIn
          - Source.sum -> Add.a
          - Add.sum -> Show.a
          - Add.sum -> Other.a
    """)
    assert run.tick() == ["Show 1", "Source 5", "Other 6"]
    assert computes_of(run, "Add") == 2
    assert run.tick() == ["Show 6", "Source 5", "Other 6"]
    assert computes_of(run, "Add") == 1  # Source computed after it was last read, not before Show


def test_r8_a_source_in_an_untaken_branch_makes_nothing_stale(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: Door, Source: {type: Do, inputs: {a: 5.0}}, Add: Add, Show: Do}
        connections:
          - Tick.tick -> Door.execIn
          - Door.execOut -> Source.execIn
          - Tick.tick -> Show.execIn
          - Source.sum -> Add.a
          - Add.sum -> Show.a
    """)
    assert run.tick() == ["Source 5", "Show 5"]
    assert computes_of(run, "Add") == 1
    run["Door"].open = False
    assert run.tick() == ["Show 5"]
    assert computes_of(run, "Add") == 0


def test_r8_what_depends_on_a_node_that_did_not_run_since_play_is_computed_of_its_defaults(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Door: Door, Source: {type: Do, inputs: {a: 5.0}}, Add: {type: Add, inputs: {b: 1.0}}, Show: Do}
        connections:
          - Tick.tick -> Door.execIn
          - Door.execOut -> Source.execIn
          - Tick.tick -> Show.execIn
          - Source.sum -> Add.a
          - Add.sum -> Show.a
    """)
    assert run.tick() == ["Source 5", "Show 6"]
    run.stop()
    run["Door"].open = False
    assert run.tick() == ["Show 1"]


def test_r8_each_node_of_a_chain_is_computed_once_after_a_change_at_its_head(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, One: Add, Two: Add, Three: Add, Show: Do, Other: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.tick -> Other.execIn
          - Tick.number -> One.a
          - One.sum -> Two.a
          - One.sum -> Two.b
          - Two.sum -> Three.a
          - One.sum -> Three.b
          - Three.sum -> Show.a
          - Two.sum -> Other.a
    """)
    assert run.ticks(2) == [["Show 3", "Other 2"], ["Show 6", "Other 4"]]
    assert [computes_of(run, node) for node in ("One", "Two", "Three")] == [2, 2, 2]


def test_r8_a_loop_index_moves_what_hangs_on_it_and_nothing_else(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Moves: Add, Stays: Add, Show: Do, Other: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Show.execIn
          - Show.execOut -> Other.execIn
          - Tick.number -> Stays.a
          - ForLoop.index -> Moves.a
          - Stays.sum -> Moves.b
          - Moves.sum -> Show.a
          - Stays.sum -> Show.b
          - Moves.sum -> Other.a
    """)
    assert run.tick() == ["Show 2", "Other 1", "Show 3", "Other 2", "Show 4", "Other 3"]
    assert computes_of(run, "Stays") == 1
    assert computes_of(run, "Moves") == 3


def test_r8_ports_that_one_yield_fires_together_share_what_hangs_on_the_index(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Both: Both, Add: Add, A: Do, B: Do}
        connections:
          - Tick.tick -> Both.execIn
          - Both.a -> A.execIn
          - Both.b -> B.execIn
          - Both.index -> Add.a
          - Add.sum -> A.a
          - Add.sum -> B.a
    """)
    assert run.tick() == ["A 0", "B 0", "A 1", "B 1"]
    assert computes_of(run, "Add") == 2


def test_r8_what_a_loop_body_computes_is_fresh_behind_the_loop(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Total: Do, Add: {type: Add, inputs: {b: 100.0}}, Before: Do, Show: Do}
        connections:
          - Tick.tick -> Before.execIn
          - Before.execOut -> ForLoop.execIn
          - ForLoop.loopBody -> Total.execIn
          - ForLoop.finished -> Show.execIn
          - Total.sum -> Total.a
          - ForLoop.index -> Total.b
          - Total.sum -> Add.a
          - Add.sum -> Before.a
          - Add.sum -> Show.a
    """)
    assert run.tick() == ["Before 100", "Total 0", "Total 1", "Total 3", "Show 103"]
    assert computes_of(run, "Add") == 2
    assert run.tick() == ["Before 103", "Total 3", "Total 4", "Total 6", "Show 106"]
    assert computes_of(run, "Add") == 1


def test_r8_what_reads_from_outside_has_one_version_a_tick(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Ticket: Ticket, Add: Add, Sequence: Sequence, A: Do, B: Do, C: Do}
        connections:
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> A.execIn
          - Sequence.b -> B.execIn
          - Tick.tick -> C.execIn
          - Ticket.number -> Add.a
          - Add.sum -> A.a
          - Ticket.number -> B.a
          - Add.sum -> C.a
    """)
    assert run.ticks(3) == [["A 1", "B 1", "C 1"], ["A 2", "B 2", "C 2"], ["A 3", "B 3", "C 3"]]


def test_r8_a_data_node_shows_what_a_latent_node_put_out_meanwhile(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Go: {type: Every, inputs: {n: 2}}, Delay: {type: Delay, inputs: {duration: 9.0}}, Add: Add, Show: Do}
        connections:
          - Go.fired -> Delay.execIn
          - Tick.tick -> Show.execIn
          - Delay.updates -> Add.a
          - Add.sum -> Show.a
    """)
    assert run.ticks(4) == [["Show 0"], ["Show 0"], ["Show 1"], ["Show 2"]]


def test_r8_a_data_node_that_nothing_reads_is_not_computed(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Add: Add, Constant: {type: Add, inputs: {a: 1.0}}, After: Add, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.number -> Add.a
          - Constant.sum -> After.a
    """)
    run.ticks(2)
    assert [computes_of(run, node) for node in ("Add", "Constant", "After")] == [0, 0, 0]
    assert [run.index(node) in run.plan.order for node in ("Add", "Constant", "After")] == [False] * 3


# R9


def test_r9_an_untaken_branch_computes_nothing_its_data_nodes_included(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Branch: Branch, Yes: Do, No: Do, ForYes: Add, ForNo: Add, Shared: Add}
        connections:
          - Tick.tick -> Branch.execIn
          - Branch.execTrue -> Yes.execIn
          - Branch.execFalse -> No.execIn
          - Tick.number -> Shared.a
          - Shared.sum -> ForYes.a
          - Shared.sum -> ForNo.a
          - ForYes.sum -> Yes.a
          - ForNo.sum -> No.a
    """)
    assert run.tick() == ["Branch False", "No 1"]
    assert [computes_of(run, node) for node in ("ForYes", "ForNo", "Shared")] == [0, 1, 1]
    run["Branch"].condition = True
    assert run.tick() == ["Branch True", "Yes 2"]
    assert [computes_of(run, node) for node in ("ForYes", "ForNo", "Shared")] == [1, 0, 1]


def test_r9_a_data_node_that_only_one_of_two_branches_refreshed_is_refreshed_where_they_merge(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Branch: Branch, Yes: Do, Merge: Do, Add: Add}
        connections:
          - Tick.tick -> Branch.execIn
          - Branch.execTrue -> Yes.execIn
          - Branch.execFalse -> Merge.execIn
          - Yes.execOut -> Merge.execIn
          - Tick.number -> Add.a
          - Add.sum -> Yes.a
          - Add.sum -> Merge.a
    """)
    assert run.tick() == ["Branch False", "Merge 1"]
    assert computes_of(run, "Add") == 1
    run["Branch"].condition = True
    assert run.tick() == ["Branch True", "Yes 2", "Merge 2"]
    assert computes_of(run, "Add") == 1


def test_r9_outputs_hold_their_last_value_while_their_node_does_not_run(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Every: {type: Every, inputs: {n: 2}}, Source: Do, Show: Do}
        connections:
          - Every.fired -> Source.execIn
          - Tick.tick -> Show.execIn
          - Tick.number -> Source.a
          - Source.sum -> Show.a
    """)
    assert run.ticks(4) == [["Show 0"], ["Source 2", "Show 2"], ["Show 2"], ["Source 4", "Show 4"]]


def test_r9_an_unreached_consumer_keeps_its_data_nodes_at_rest(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Show: Do, Lost: Do, Add: Add}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.number -> Add.a
          - Add.sum -> Lost.a
    """)
    run.tick()
    assert computes_of(run, "Add") == 0


# R10


READ_WRITE_READ = """
    variables: {speed: {type: double, default: 1.0}}
    nodes:
      Tick: Tick
      Read: ReadVariable
      Write: {type: WriteVariable, inputs: {value: 2.0}}
      Before: Do
      After: Do
"""


def test_r10_a_write_is_seen_by_reads_after_it_and_not_by_reads_before_it(bench: MakeBench) -> None:
    run = bench(
        READ_WRITE_READ
        + """
    connections:
      - Tick.tick -> Before.execIn
      - Before.execOut -> Write.execIn
      - Write.execOut -> After.execIn
      - Read.value -> Before.a
      - Read.value -> After.a
    """
    )
    assert run.codes == []  # execution says it all
    assert run.tick() == ["Before 1", "Write 2", "After 2"]
    assert computes_of(run, "Read") == 2
    assert run.tick() == ["Before 2", "Write 2", "After 2"]


def test_r10_a_sequence_is_a_stated_order(bench: MakeBench) -> None:
    run = bench(
        READ_WRITE_READ.replace("nodes:\n", "nodes:\n      Sequence: Sequence\n")
        + """
    connections:
      - Tick.tick -> Sequence.execIn
      - Sequence.a -> Before.execIn
      - Sequence.b -> Write.execIn
      - Sequence.c -> After.execIn
      - Read.value -> Before.a
      - Read.value -> After.a
    """
    )
    assert run.codes == []
    assert run.ticks(2) == [["Before 1", "Write 2", "After 2"], ["Before 2", "Write 2", "After 2"]]


def test_r10_without_a_stated_order_readers_come_after_the_writer_and_a_lint_says_so(bench: MakeBench) -> None:
    run = bench(
        READ_WRITE_READ
        + """
    connections:
      - Tick.tick -> Before.execIn
      - Tick.tick -> Write.execIn
      - Write.execOut -> After.execIn
      - Read.value -> Before.a
      - Read.value -> After.a
    """
    )
    assert run.codes == ["W105"]
    assert run.message("W105") == "Before reads and Write writes variable speed, in no stated order"
    assert run.tick() == ["Write 2", "Before 2", "After 2"]


@pytest.mark.parametrize("starts", ["Before", "Write"])
def test_r10_who_never_runs_needs_no_order(bench: MakeBench, starts: str) -> None:
    run = bench(
        READ_WRITE_READ
        + f"""
    connections:
      - Tick.tick -> {starts}.execIn
      - Read.value -> Before.a
    """
    )
    assert "W105" not in run.codes


def test_r10_below_one_port_of_a_loop_the_order_is_not_stated(bench: MakeBench) -> None:
    run = bench(
        READ_WRITE_READ.replace("nodes:\n", "nodes:\n      ForLoop: ForLoop\n")
        + """
    connections:
      - Tick.tick -> ForLoop.execIn
      - ForLoop.loopBody -> Before.execIn
      - ForLoop.loopBody -> Write.execIn
      - Read.value -> Before.a
    """
    )
    assert run.codes == ["W105"]


def test_r10_a_variable_counts_up_when_its_writer_reads_it(bench: MakeBench) -> None:
    run = bench("""
        variables: {speed: {type: double, default: 1.0}}
        nodes: {Tick: Tick, Read: ReadVariable, Add: {type: Add, inputs: {b: 1.0}}, Write: WriteVariable}
        connections:
          - Tick.tick -> Write.execIn
          - Read.value -> Add.a
          - Add.sum -> Write.value
    """)
    assert run.codes == []
    assert run.ticks(3) == [["Write 2"], ["Write 3"], ["Write 4"]]


def test_r10_a_write_in_a_loop_is_seen_by_the_next_iteration(bench: MakeBench) -> None:
    run = bench("""
        variables: {speed: {type: double, default: 1.0}}
        nodes: {Tick: Tick, ForLoop: ForLoop, Read: ReadVariable, Add: Add, Show: Do, Write: WriteVariable}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Show.execIn
          - Show.execOut -> Write.execIn
          - Read.value -> Show.a
          - Read.value -> Add.a
          - Read.value -> Add.b
          - Add.sum -> Write.value
    """)
    assert run.tick() == ["Show 1", "Write 2", "Show 2", "Write 4", "Show 4", "Write 8"]


# Wires from inputs


def test_a_wire_from_a_wired_input_carries_what_is_wired_there(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Middle: Do, Show: Do, Add: {type: Add, inputs: {b: 1.0}}}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.tick -> Middle.execIn
          - Tick.number -> Add.a
          - Middle.inputs:a -> Show.a
          - Add.sum -> Middle.a
    """)
    assert run.ticks(2) == [["Show 2", "Middle 2"], ["Show 3", "Middle 3"]]


def test_a_wire_from_a_wired_input_carries_the_converted_value(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Whole: {type: Whole, inputs: {value: 3}}, Middle: Do, Show: Show}
        connections:
          - Tick.tick -> Middle.execIn
          - Tick.tick -> Show.execIn
          - Whole.out -> Middle.a
          - Middle.inputs:a -> Show.value
    """)
    run.tick()
    assert isinstance(run["Show"].value, float)


def test_a_data_node_may_read_an_input_of_an_executed_node_that_comes_later_in_the_file(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Last: {type: Add, inputs: {b: 1.0}}, Middle: Do, First: {type: Add, inputs: {b: 1.0}}, Show: Do}
        connections:
          - Tick.tick -> Middle.execIn
          - Tick.tick -> Show.execIn
          - Tick.number -> First.a
          - First.sum -> Middle.a
          - Middle.inputs:a -> Last.a
          - Last.sum -> Show.a
    """)
    assert run.ticks(2) == [["Middle 2", "Show 3"], ["Middle 3", "Show 4"]]


def test_a_constant_read_off_a_node_that_is_read_back_is_no_cycle(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, One: {type: Add, inputs: {b: 1.0}}, Two: {type: Add, inputs: {a: 2.0}}, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Two.inputs:a -> One.a
          - One.sum -> Two.b
          - Two.sum -> Show.a
    """)
    assert run.tick() == ["Show 5"]
