"""Design 3.4: setup, its order and its inputs; what happens when they change."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError, NodeError
from tests.compiler.conftest import MakeBench, MakeFile
from tests.compiler.harness import Bench, planned


def test_setup_follows_the_schedule_each_data_node_before_its_first_consumer(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Late: Do, Sequence: Sequence, Tick: Tick, Sum: Add, First: Do, Zero: Constant}
        connections:
          - Tick.tick -> Sequence.execIn
          - Sequence.a -> First.execIn
          - Sequence.b -> Late.execIn
          - First.sum -> Sum.a
          - Sum.sum -> Late.a
          - Zero.value -> Late.b
    """)
    order = [run.graph.instances[index].id for index in run.plan.order]
    assert order == ["Zero", "Tick", "Sequence", "First", "Sum", "Late"]


def test_an_input_that_is_read_in_setup_gets_folded_constants(bench: MakeBench) -> None:
    run = bench("""
        nodes:
          Tick: Tick
          Text: {type: Text, inputs: {a: sc, b: an}}
          More: {type: Text, inputs: {b: _2}}
          Announce: Announce
        connections:
          - Tick.tick -> Announce.execIn
          - Text.text -> More.a
          - More.text -> Announce.topic
    """)
    assert run.journal.read() == ["Announce opens /scan_2"]
    assert run.tick() == ["Announce sends on /scan_2"]


def test_an_input_that_is_read_in_setup_gets_what_earlier_setups_put_out(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, First: {type: Announce, inputs: {topic: scan}}, Second: Announce}
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Second.execIn
          - First.opened -> Second.topic
    """)
    assert run.journal.read() == ["First opens /scan", "Second opens //scan"]
    assert run.tick() == ["First sends on /scan", "Second sends on //scan"]


def test_an_input_that_is_read_in_setup_gets_them_through_data_nodes_too(bench: MakeBench) -> None:
    run = bench("""
        nodes:
          Tick: Tick
          First: {type: Announce, inputs: {topic: scan}}
          Text: {type: Text, inputs: {b: _filtered}}
          More: Text
          Second: Announce
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Second.execIn
          - First.opened -> Text.a
          - Text.text -> More.a
          - More.text -> Second.topic
    """)
    assert run.journal.read() == ["First opens /scan", "Second opens //scan_filtered"]
    assert run.tick() == ["First sends on /scan", "Second sends on //scan_filtered"]


def test_a_data_node_that_cannot_be_computed_before_the_first_pass_is_left_alone(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Spell: Spell, Text: {type: Text, inputs: {strict: true}}, Announce: Announce}
        connections:
          - Tick.tick -> Spell.execIn
          - Spell.execOut -> Announce.execIn
          - Spell.text -> Text.a
          - Text.text -> Announce.topic
    """)
    assert run.journal.read() == ["Announce opens /"]
    assert run.tick() == ["Announce opens /t1", "Announce sends on /t1"]


def test_data_nodes_that_no_setup_waits_for_are_not_computed_in_setup(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Reciprocal: Reciprocal, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.number -> Reciprocal.value
          - Reciprocal.result -> Show.a
    """)
    assert run.tick() == ["Show 1"]


def test_a_wire_that_changes_at_run_time_sets_the_node_up_again(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Every: {type: Every, inputs: {n: 2}}, Spell: Spell, Announce: Announce}
        connections:
          - Every.fired -> Spell.execIn
          - Tick.tick -> Announce.execIn
          - Spell.text -> Announce.topic
    """)
    assert run.journal.read() == ["Announce opens /"]
    assert run.ticks(4) == [
        ["Announce sends on /"],
        ["Announce opens /t1", "Announce sends on /t1"],
        ["Announce sends on /t1"],
        ["Announce opens /t2", "Announce sends on /t2"],
    ]


def test_what_a_node_was_handed_is_closed_before_it_is_set_up_again(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Spell: Spell, Announce: Announce}
        connections:
          - Tick.tick -> Spell.execIn
          - Spell.execOut -> Announce.execIn
          - Spell.text -> Announce.topic
    """)
    run.ticks(3)
    assert run.journal.open == 1
    assert len(run.services.claims) == 1


def test_two_inputs_that_change_together_set_the_node_up_once(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Spell: Spell, Announce: Announce}
        connections:
          - Tick.tick -> Spell.execIn
          - Spell.execOut -> Announce.execIn
          - Spell.text -> Announce.topic
          - Spell.text -> Announce.qualifier
    """)
    run.journal.read()
    assert run.tick() == ["Announce opens /t1t1", "Announce sends on /t1t1"]


def test_a_setup_that_fails_names_its_node(file: MakeFile) -> None:
    run = Bench(
        file("""
        nodes: {Tick: Tick, Announce: {type: Announce, inputs: {topic: forbidden}}}
        connections: [Tick.tick -> Announce.execIn]
        """)
    )
    with pytest.raises(NodeError, match=r"node Announce .*this topic is forbidden"):
        run.setup()


def test_a_setup_that_fails_does_not_keep_the_others_from_theirs_when_somebody_listens(file: MakeFile) -> None:
    run = Bench(
        file("""
        nodes:
          Tick: Tick
          Bad: {type: Announce, inputs: {topic: forbidden}}
          Reciprocal: {type: Reciprocal, inputs: {value: 0.0}}
          Good: {type: Announce, inputs: {topic: scan}}
          Show: Do
        connections:
          - Tick.tick -> Bad.execIn
          - Bad.execOut -> Good.execIn
          - Tick.tick -> Show.execIn
          - Reciprocal.result -> Show.a
        """)
    )
    failed: list[tuple[str, GraphError]] = []
    run.executor.setup(lambda index, error: failed.append((run.graph.instances[index].id, error)))
    assert [node for node, _ in failed] == ["Reciprocal", "Bad"]
    assert run.journal.read() == ["Good opens /scan"]


def test_nodes_that_nothing_reaches_are_not_set_up(file: MakeFile) -> None:
    run = Bench(
        file("""
        nodes: {Tick: Tick, Show: Do, Lost: {type: Announce, inputs: {topic: forbidden}}}
        connections: [Tick.tick -> Show.execIn]
        """)
    )
    run.setup()
    assert run.journal.read() == []


def test_both_kinds_of_cycle_are_told_in_one_run(file: MakeFile) -> None:
    findings = Findings()
    path = file("""
        nodes: {A: Add, B: Do}
        connections:
          - A.sum -> A.a
          - B.execOut -> B.execIn
    """)
    assert planned(path, findings) is None
    assert sorted(found.code for found in findings.items) == ["G209", "G210"]
