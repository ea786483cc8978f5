"""Gates, counters and sync gates: alone, and in graphs."""

from __future__ import annotations

import pytest

from graphengine.nodes.action.gates import Counter, FlipFlop, Gate, Multigate, Once, RationalTimeSyncGate, SyncGate
from graphengine.testing import RecordingContext
from tests.nodes.firing import fired, of
from tests.nodes.harness import Player

# Gates


@pytest.mark.parametrize("closed", [True, False])
def test_a_gate_fires_while_it_is_open_and_a_toggle_opens_or_closes_it(closed: bool) -> None:
    node, opened = Gate(start_closed=closed), ["", "exit_out"]
    assert fired(node, "enter") == opened[not closed]
    assert fired(node, "toggle") == ""
    assert fired(node, "enter") == opened[closed]
    RecordingContext().stop(node)
    assert fired(node, "enter") == opened[not closed]


def test_a_toggle_acts_before_an_entry_of_the_same_pass() -> None:
    node = Gate(start_closed=True)
    node.toggle = 1
    assert fired(node, "enter") == "exit_out"


def test_a_multigate_fires_one_output_after_the_other_and_begins_again() -> None:
    node = of(Multigate, "output1", "output2")
    assert [fired(node) for _ in range(4)] == ["output0", "output1", "output2", "output0"]
    assert fired(node, "reset_in") == ""
    assert fired(node) == "output0"


def test_a_multigate_fires_nothing_in_the_turn_of_an_unwired_output() -> None:
    node = of(Multigate, "output2", "output4")
    assert [fired(node) for _ in range(6)] == ["output0", "", "output2", "", "output4", "output0"]


def test_in_a_graph_a_multigate_counts_outputs_by_their_numbers(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Gates: Multigate, First: Counter, Third: Counter}
        connections: [Tick.tick -> Gates.execIn, Gates.output0 -> First.execIn, Gates.output2 -> Third.execIn]
        """
    ).tick(7)
    assert (playing.node("First").count, playing.node("Third").count) == (3, 2)
    playing.session.stop()
    playing.tick()
    assert playing.node("First").count == 1


def test_is_a_of_a_flip_flop_is_the_last_fired_output() -> None:
    node = FlipFlop()
    assert [(fired(node), node.is_a) for _ in range(3)] == [("a", True), ("b", False), ("a", True)]


def test_once_fires_its_first_output_once_until_a_reset() -> None:
    node = Once()
    assert [fired(node) for _ in range(3)] == ["once", "after", "after"]
    assert fired(node, "reset_in") == ""
    assert fired(node) == "once"


def test_a_counter_counts_until_it_is_reset() -> None:
    node, counts = Counter(), []
    for pin in ("exec_in", "exec_in", "reset_in", "exec_in"):
        fired(node, pin)
        counts.append(node.count)
    assert counts == [1, 2, 0, 1]


SYNC = """
nodes: {Tick: OnPlaybackTick, Order: Multisequence, Left: Counter, Right: Counter, Sync: SyncGate, Passed: Counter}
connections:
  - Tick.tick -> Order.execIn
  - Order.output0 -> Left.execIn
  - Order.output1 -> Right.execIn
  - Left.execOut -> Sync.execIn
  - Right.execOut -> Sync.execIn
  - Sync.execOut -> Passed.execIn
"""


def test_a_sync_gate_waits_for_all_of_its_wires(play: Player) -> None:
    playing = play.graph(SYNC).tick(3)
    assert playing.node("Passed").count == 3
    playing = play.graph(SYNC.replace("  - Tick.tick -> Order.execIn", "  - Tick.tick -> Left.execIn"))
    assert playing.each_tick(4, lambda: playing.node("Passed").count) == [0, 1, 1, 2]


def test_a_sync_gate_restarts_its_count_at_another_value() -> None:
    node = SyncGate(sync_value_in=7)
    node.wires = 2
    assert [fired(node), fired(node), fired(node)] == ["", "exec_out", ""]
    node.sync_value_in = 8
    assert [fired(node), node.sync_value_out, fired(node)] == ["", 8, "exec_out"]


def test_a_rational_sync_gate_compares_times_as_fractions() -> None:
    node = RationalTimeSyncGate(numerator_in=1, denominator_in=2)
    node.wires = 2
    assert fired(node) == ""
    node.numerator_in, node.denominator_in = 2, 4
    assert fired(node) == "exec_out"
    node.numerator_in = 3
    assert [fired(node), fired(node)] == ["", "exec_out"]


def test_without_denominators_a_rational_sync_gate_compares_numerators() -> None:
    node = RationalTimeSyncGate(numerator_in=1)
    node.wires = 2
    arrivals = []
    for numerator in (1, 2, 2):
        node.numerator_in = numerator
        arrivals.append(fired(node))
    assert arrivals == ["", "", "exec_out"]


def test_in_a_graph_a_rational_sync_gate_waits_for_all_of_its_wires(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Other: {type: OnPlaybackTick, every: {ticks: 2}}
          Sync: {type: RationalTimeSyncGate, inputs: {rationalTimeNumerator: 1, rationalTimeDenominator: 60}}
          Count: Counter
        connections: [Tick.tick -> Sync.execIn, Other.tick -> Sync.execIn, Sync.execOut -> Count.execIn]
        """
    ).tick(4)
    assert (playing.node("Count").count, playing.node("Sync").denominator_out) == (3, 60)
    playing.session.stop()
    assert (playing.node("Count").count, playing.node("Sync").denominator_out) == (0, 0)
