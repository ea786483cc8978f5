"""Design 3.4: setup, its order and its inputs; what happens when they change."""

from __future__ import annotations

import pytest

from graphengine.format.errors import GraphError, NodeError
from tests.compiler.conftest import MakeBench, MakeFile
from tests.compiler.harness import Bench


def test_endpoints_of_a_node_are_closed_before_its_next_setup(bench: MakeBench) -> None:
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


def test_a_setup_that_fails_names_its_node(file: MakeFile) -> None:
    run = Bench(
        file("""
        nodes: {Tick: Tick, Announce: {type: Announce, inputs: {topic: forbidden}}}
        connections: [Tick.tick -> Announce.execIn]
        """)
    )
    with pytest.raises(NodeError, match=r"node Announce .*this topic is forbidden"):
        run.setup()


def test_with_a_fault_handler_other_nodes_are_set_up_after_a_setup_fails(file: MakeFile) -> None:
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
