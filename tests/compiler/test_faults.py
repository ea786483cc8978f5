"""R11, R14: who is named when something raises, and a run that keeps going."""

from __future__ import annotations

import gc
import linecache
import traceback

import pytest

from graphengine.compiler.codegen import source_of
from graphengine.format.errors import NodeError
from tests.compiler.conftest import MakeBench
from tests.compiler.nodes_for_tests.pushers import ForLoop


def test_r14_a_data_node_that_raises_is_named_and_not_its_consumer(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Minus: {type: Add, inputs: {b: -1.0}}, Reciprocal: Reciprocal, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.number -> Minus.a
          - Minus.sum -> Reciprocal.value
          - Reciprocal.result -> Show.a
    """)
    with pytest.raises(NodeError, match=r"node Reciprocal .*division by zero") as caught:
        run.tick()
    assert "inputs: value=0.0" in str(caught.value)


def test_r14_a_node_below_a_pusher_is_named_and_not_the_pusher(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, Raise: {type: Raise, inputs: {at: 2.0}}}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Raise.execIn
    """)
    with pytest.raises(NodeError, match=r"node Raise "):
        run.tick()


def test_r14_a_pusher_that_raises_between_two_yields_is_named(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: ForLoop, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
    """)
    run["ForLoop"].stop = "three"
    with pytest.raises(NodeError, match=r"node ForLoop .*TypeError"):
        run.tick()


def test_r14_a_latent_node_that_raises_later_is_named(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Every: {type: Every, inputs: {n: 1}}, FailsLater: FailsLater}
        connections: [Every.fired -> FailsLater.execIn]
    """)
    run.tick()
    with pytest.raises(NodeError, match=r"node FailsLater .*tired") as caught:
        run.tick()
    assert isinstance(caught.value.__cause__, RuntimeError)


ANNOUNCES_T2 = """
    nodes: {Tick: Tick, Spell: Spell, Announce: {type: Announce, inputs: {forbidden: t2}}, After: Do}
    connections:
      - Tick.tick -> Spell.execIn
      - Spell.execOut -> Announce.execIn
      - Announce.execOut -> After.execIn
      - Spell.text -> Announce.topic
"""


def test_r14_a_node_whose_repeated_setup_fails_is_named(bench: MakeBench) -> None:
    run = bench(ANNOUNCES_T2)
    run.tick()
    with pytest.raises(NodeError, match=r"node Announce .*this topic is forbidden") as caught:
        run.tick()
    assert "at tick 2" in str(caught.value)


def test_r14_a_traceback_shows_the_lines_of_the_generated_tick(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, Raise: Raise}
        connections: [Tick.tick -> Raise.execIn]
    """)
    with pytest.raises(NodeError) as caught:
        run.tick()
    shown = "".join(traceback.format_exception(caught.value))
    name = source_of(run.plan).name
    assert name in shown
    assert "    c1()" in shown
    del run, caught
    gc.collect()
    assert name not in linecache.cache


KEEPS_GOING = """
    nodes:
      Tick: Tick
      Raise: {type: Raise, inputs: {at: 2.0}}
      Below: Do
      Further: Do
      Beside: Do
      Merge: Join
    connections:
      - Tick.tick -> Raise.execIn
      - Raise.execOut -> Below.execIn
      - Below.execOut -> Further.execIn
      - Tick.tick -> Beside.execIn
      - Further.execOut -> Merge.first
      - Beside.execOut -> Merge.second
"""


def test_r14_keep_going_changes_nothing_while_no_node_raises(bench: MakeBench) -> None:
    quiet = KEEPS_GOING.replace("at: 2.0", "at: 0.0")
    assert bench(quiet, keep_going=True).ticks(3) == bench(quiet).ticks(3)


def test_r11_an_endless_loop_is_an_error_with_its_limit(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Tick: Tick, ForLoop: {type: ForLoop, inputs: {stop: 100001}}, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
    """)
    with pytest.raises(NodeError, match=r"ForLoop .* did not end within 100000 iterations"):
        run.tick()


def test_r11_a_node_type_can_set_its_own_limit_of_iterations(bench: MakeBench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ForLoop, "max_pushes", 4)  # three iterations and finished
    run = bench("""
        nodes: {Tick: Tick, ForLoop: {type: ForLoop, inputs: {stop: 3}}, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
    """)
    assert run.tick() == ["A 0", "A 0", "A 0"]
    run["ForLoop"].stop = 4
    with pytest.raises(NodeError, match="within 4 iterations"):
        run.tick()
