"""R14: who is named when something raises, and a run that keeps going."""

from __future__ import annotations

import gc
import linecache
import traceback

import pytest

from graphengine.compiler.codegen import source_of
from graphengine.format.errors import NodeError
from tests.compiler.conftest import MakeBench


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


def test_r14_a_node_that_cannot_be_set_up_anew_is_named(bench: MakeBench) -> None:
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


def test_r14_a_run_that_keeps_going_ends_the_branch_of_the_node_that_raised_and_no_other(bench: MakeBench) -> None:
    run = bench(KEEPS_GOING, keep_going=True)
    whole = ["Below 0", "Further 0", "Beside 0", "Merge first=1 second=1 hold=0"]
    assert run.tick() == whole
    assert run.tick() == ["Beside 0", "Merge first=0 second=1 hold=0"]
    assert run.tick() == whole
    (fault,) = run.faults
    assert "node Raise " in str(fault)
    assert isinstance(fault.__cause__, ZeroDivisionError)


def test_r14_a_run_that_keeps_going_does_the_same_as_another_while_nothing_raises(bench: MakeBench) -> None:
    quiet = KEEPS_GOING.replace("at: 2.0", "at: 0.0")
    assert bench(quiet, keep_going=True).ticks(3) == bench(quiet).ticks(3)


def test_r14_what_the_node_that_raised_put_out_before_is_seen_by_its_readers(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Tick: Tick, First: Do, Raise: {type: Raise, inputs: {at: 1.0}}, Add: Add, Show: Do}
        connections:
          - Tick.tick -> First.execIn
          - First.execOut -> Raise.execIn
          - First.execOut -> Show.execIn
          - Raise.count -> Add.a
          - Add.sum -> First.a
          - Add.sum -> Show.a
        """,
        keep_going=True,
    )
    assert run.ticks(2) == [["First 0", "Show 1"], ["First 1", "Show 2"]]
    assert len(run.faults) == 1


def test_r14_pins_of_a_node_that_raised_are_clear_the_next_time(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Tick: Tick, Counter: Counter, Gate: Gate, A: Do}
        connections:
          - Tick.tick -> Counter.execIn
          - Tick.tick -> Counter.second
          - Counter.execOut -> A.execIn
          - A.execOut -> Counter.reset
        """,
        keep_going=True,
    )
    run["Counter"].step = None  # raises
    assert run.tick() == []
    assert len(run.faults) == 2
    run["Counter"].step = 1.0
    assert run.tick() == ["Counter in=1 second=0 reset=0 count=1", "Counter in=0 second=1 reset=0 count=2", "A 0"]


def test_r14_a_data_node_that_raises_in_a_run_that_keeps_going_keeps_its_last_output(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Tick: Tick, Minus: {type: Add, inputs: {b: -2.0}}, Reciprocal: Reciprocal, Show: Do, Other: Do}
        connections:
          - Tick.tick -> Show.execIn
          - Tick.tick -> Other.execIn
          - Tick.number -> Minus.a
          - Minus.sum -> Reciprocal.value
          - Reciprocal.result -> Show.a
          - Reciprocal.result -> Other.a
        """,
        keep_going=True,
    )
    assert run.ticks(3) == [["Show -1", "Other -1"], ["Show -1", "Other -1"], ["Show 1", "Other 1"]]
    (fault,) = run.faults
    assert "node Reciprocal " in str(fault)


def test_r14_a_loop_goes_on_when_its_body_raised(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Tick: Tick, ForLoop: ForLoop, Raise: {type: Raise, inputs: {at: 2.0}}, A: Do, End: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> Raise.execIn
          - Raise.execOut -> A.execIn
          - ForLoop.index -> A.a
          - ForLoop.finished -> End.execIn
        """,
        keep_going=True,
    )
    assert run.tick() == ["A 0", "A 2", "End 0"]


def test_r14_a_loop_that_raises_itself_ends(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Tick: Tick, ForLoop: ForLoop, A: Do, B: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
          - Tick.tick -> B.execIn
        """,
        keep_going=True,
    )
    run["ForLoop"].stop = "three"
    assert run.tick() == ["B 0"]
    assert len(run.faults) == 1


def test_r14_an_event_that_raises_fires_nothing(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Every: Every, Tick: Tick, A: Do, B: Do}
        connections:
          - Every.fired -> A.execIn
          - Tick.tick -> B.execIn
        """,
        keep_going=True,
    )
    run["Every"].n = 0
    assert run.tick() == ["B 0"]
    assert len(run.faults) == 1


def test_r14_a_latent_node_that_raises_in_a_run_that_keeps_going_ends(bench: MakeBench) -> None:
    run = bench(
        """
        nodes: {Every: {type: Every, inputs: {n: 1}}, Tick: Tick, FailsLater: FailsLater, Show: Do, Add: Add}
        connections:
          - Every.fired -> FailsLater.execIn
          - Tick.tick -> Show.execIn
          - FailsLater.updates -> Add.a
          - Add.sum -> Show.a
        """,
        keep_going=True,
    )
    run.tick()
    run["Every"].n = 1000
    assert run.ticks(3) == [["Show 1"], ["Show 2"], ["Show 2"]]
    assert not run["FailsLater"].active
    assert len(run.faults) == 1


def test_r14_a_setup_that_fails_at_run_time_ends_the_branch(bench: MakeBench) -> None:
    run = bench(ANNOUNCES_T2, keep_going=True)
    run.journal.read()
    assert run.ticks(3) == [
        ["Announce opens /t1", "Announce sends on /t1", "After 0"],
        [],
        ["Announce opens /t3", "Announce sends on /t3", "After 0"],
    ]
    assert len(run.faults) == 1
