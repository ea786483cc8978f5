"""Branch, Multisequence, Sequence, SwitchToken, the gates and the loops: alone, and in graphs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from graphengine.diagnostics import NodeError
from graphengine.node import Node, grown
from graphengine.ros.definitions import DEFINITIONS
from graphengine.testing import RecordingContext
from nodes.action.branching import Branch, Multisequence, Sequence, SwitchToken
from nodes.action.custom import OnCustomEvent, SendCustomEvent
from nodes.action.gates import Counter, FlipFlop, Gate, Multigate, Once, RationalTimeSyncGate, SyncGate
from nodes.action.loops import ForEach, ForEachTarget, ForLoop, WhileLoop
from nodes.action.waiting import Countdown, Delay
from tests.nodes.harness import Player, Playing, ready


def fired(node: Any, pin: str = "exec_in") -> str:
    """The outputs that a node fires when one of its pins does, by name."""
    setattr(node, pin, 1)
    ports = node.compute()
    setattr(node, pin, 0)
    outputs = [p.field for p in type(node).fields.values() if p.side == "outputs" and p.is_exec]
    return " ".join(name for name in outputs if (ports or 0) & getattr(node, name))


def of(cls: type[Node], *wired: str, **literals: Any) -> Any:
    """A node whose file names these ports and values."""
    made: Any = grown(cls, literals, DEFINITIONS, wired)
    return made(**literals)


# Branch, Sequence


@pytest.mark.parametrize(("condition", "expected"), [(True, "exec_true"), (False, "exec_false")])
def test_a_branch_fires_one_of_its_outputs(condition: bool, expected: str) -> None:
    assert fired(Branch(condition=condition)) == expected


def test_a_sequence_alternates_as_the_hidden_type_of_isaac_does() -> None:
    node = Sequence()
    assert [fired(node) for _ in range(4)] == ["a", "b", "a", "b"]
    RecordingContext().stop(node)
    assert fired(node) == "a"


# Multisequence


def test_a_multisequence_has_the_outputs_that_wires_begin_at_and_fires_them_by_number() -> None:
    node = of(Multisequence, "output10", "output2", "output1")
    assert list(node.compute()) == [node.output0, node.output1, node.output2, node.output10]


def test_a_multisequence_ends_what_hangs_on_an_output_before_the_next_begins(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Both: Multisequence
          First: Counter
          Second: Counter
          Reset: Counter
        connections:
          - Tick.tick -> Both.execIn
          - Both.output2 -> Second.reset
          - Both.output0 -> First.execIn
          - First.execOut -> Second.execIn
          - Both.output1 -> Second.execIn
          - Second.execOut -> Reset.execIn
        """
    )
    playing.tick(2)
    assert [playing.node(name).count for name in ("First", "Second", "Reset")] == [2, 0, 6]


# SwitchToken


def test_a_switch_fires_the_output_of_the_branch_that_has_the_value() -> None:
    node = of(SwitchToken, "output0", "output1", branch0="stop", branch1="go", value="go")
    assert fired(node) == "output1"
    node.value = "stop"
    assert fired(node) == "output0"


def test_a_switch_takes_the_numbers_of_two_digits_that_the_editor_of_isaac_gives(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Switch: {type: SwitchToken, inputs: {branch00: a, branch01: b, branch10: c, value: b}}
          Hit: Counter
          Miss: Counter
        connections:
          - Tick.tick -> Switch.execIn
          - Switch.output00 -> Miss.execIn
          - Switch.output01 -> Hit.execIn
          - Switch.output10 -> Miss.execIn
        """
    )
    playing.tick(2)
    assert (playing.node("Hit").count, playing.node("Miss").count) == (2, 0)


def test_a_switch_without_such_a_branch_fires_nothing() -> None:
    node = of(SwitchToken, "output0", branch0="stop", value="go")
    assert fired(node) == ""
    node.value = "Stop"
    assert fired(node) == ""


def test_a_switch_whose_branch_has_no_output_fires_nothing() -> None:
    assert fired(of(SwitchToken, branch0="a", value="a")) == ""


def test_of_two_branches_with_the_value_the_lower_number_wins() -> None:
    assert fired(of(SwitchToken, "output10", "output9", branch10="a", branch9="a", value="a")) == "output9"


# Gates


@pytest.mark.parametrize("closed", [True, False])
def test_a_gate_lets_through_while_it_is_open_and_a_toggle_turns_it(closed: bool) -> None:
    node, opened = Gate(start_closed=closed), ["", "exit_out"]
    assert fired(node, "enter") == opened[not closed]
    assert fired(node, "toggle") == ""
    assert fired(node, "enter") == opened[closed]
    RecordingContext().stop(node)
    assert fired(node, "enter") == opened[not closed]


def test_a_toggle_that_comes_with_an_entry_acts_before_it() -> None:
    node = Gate(start_closed=True)
    node.toggle = 1
    assert fired(node, "enter") == "exit_out"


def test_a_multigate_fires_one_output_after_the_other_and_begins_again() -> None:
    node = of(Multigate, "output1", "output2")
    assert [fired(node) for _ in range(4)] == ["output0", "output1", "output2", "output0"]
    assert fired(node, "reset_in") == ""
    assert fired(node) == "output0"


def test_a_flip_flop_tells_which_way_it_fired() -> None:
    node = FlipFlop()
    assert [(fired(node), node.is_a) for _ in range(3)] == [("a", True), ("b", False), ("a", True)]


def test_once_is_once_until_it_is_reset() -> None:
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
nodes:
  Tick: OnPlaybackTick
  Order: Multisequence
  Left: Counter
  Right: Counter
  Sync: SyncGate
  Passed: Counter
connections:
  - Tick.tick -> Order.execIn
  - Order.output0 -> Left.execIn
  - Order.output1 -> Right.execIn
  - Left.execOut -> Sync.execIn
  - Right.execOut -> Sync.execIn
  - Sync.execOut -> Passed.execIn
"""


def test_a_sync_gate_waits_for_all_of_its_wires(play: Player) -> None:
    playing = play.graph(SYNC)
    playing.tick(3)
    assert playing.node("Passed").count == 3
    playing = play.graph(SYNC.replace("  - Tick.tick -> Order.execIn", "  - Tick.tick -> Left.execIn"))
    counts = []
    for _ in range(4):
        playing.tick()
        counts.append(playing.node("Passed").count)
    assert counts == [0, 1, 1, 2]


def test_a_sync_gate_begins_anew_with_another_value() -> None:
    node = SyncGate(sync_value_in=7)
    node.wires = 2
    assert [fired(node), fired(node), fired(node)] == ["", "exec_out", ""]
    node.sync_value_in = 8
    assert [fired(node), node.sync_value_out, fired(node)] == ["", 8, "exec_out"]


def test_a_rational_sync_gate_takes_times_for_what_they_are() -> None:
    node = RationalTimeSyncGate(numerator_in=1, denominator_in=2)
    node.wires = 2
    assert fired(node) == ""
    node.numerator_in, node.denominator_in = 2, 4
    assert fired(node) == "exec_out"
    node.numerator_in = 3
    assert [fired(node), fired(node)] == ["", "exec_out"]


def test_a_rational_sync_gate_tells_numerators_apart_where_no_denominator_is_set() -> None:
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
    )
    playing.tick(4)
    assert (playing.node("Count").count, playing.node("Sync").denominator_out) == (3, 60)
    playing.session.stop()
    assert (playing.node("Count").count, playing.node("Sync").denominator_out) == (0, 0)


# Loops


def rounds(node: Any, *outputs: str, stop_after: int | None = None) -> Iterator[tuple[Any, ...]]:
    """Outputs of a loop in each round, and at its end."""
    for number, port in enumerate(node.compute()):
        body = port == node.loop_body
        yield ("body" if body else "finished", *(getattr(node, output) for output in outputs))
        if stop_after == number:
            node.break_loop = 1


@pytest.mark.parametrize(
    ("start", "stop", "step"), [(0, 3, 1), (5, 5, 1), (2, 11, 4), (3, 0, -1), (3, 0, 1), (-2, -9, -3), (0, 3, -1)]
)
def test_a_loop_goes_from_start_to_before_stop_in_steps(start: int, stop: int, step: int) -> None:
    node = ForLoop(start=start, stop=stop, step=step)
    expected, index = [], 0
    while (start + step * index < stop) if step > 0 else (start + step * index > stop):
        expected.append(("body", index, start + step * index))
        index += 1
    seen = list(rounds(node, "index", "value"))
    assert seen[:-1] == expected
    assert seen[-1] == ("finished", *(expected[-1][1:] if expected else (0, 0)))


def test_a_step_of_zero_is_an_error() -> None:
    with pytest.raises(ValueError, match="step is 0"):
        list(ForLoop(stop=3, step=0).compute())


def test_a_broken_loop_finishes_after_the_round() -> None:
    assert list(rounds(ForLoop(stop=9), "value", stop_after=1)) == [("body", 0), ("body", 1), ("finished", 1)]


@pytest.mark.parametrize(
    ("array", "elements"),
    [
        (np.array([1.5, 2.5]), [1.5, 2.5]),
        (np.array([[1, 2], [3, 4]], np.int32), [(1, 2), (3, 4)]),
        (("a", "b"), ["a", "b"]),
        ((), []),
    ],
)
def test_for_each_gives_every_element_as_a_port_carries_it(array: Any, elements: list[Any]) -> None:
    node = ForEach(array_in=array)
    seen = list(rounds(node, "array_index", "element"))
    assert seen[:-1] == [("body", index, element) for index, element in enumerate(elements)]
    assert all(type(one[2]) is type(other) for one, other in zip(seen, elements, strict=False))
    assert seen[-1][0] == "finished"


def test_for_each_target_gives_every_prim_alone() -> None:
    node = ForEachTarget(targets=("/a", "/b"))
    assert [seen[1:] for seen in rounds(node, "array_index", "target")][:2] == [(0, ("/a",)), (1, ("/b",))]


LOOP = """
nodes:
  Tick: OnPlaybackTick
  Loop: {type: ForLoop, inputs: {start: 10, stop: 14}}
  Body: Counter
  Switch: {type: SwitchToken, inputs: {branch1: go}}
  Done: Counter
connections:
  - Tick.tick -> Loop.execIn
  - Loop.loopBody -> Body.execIn
  - Body.execOut -> Loop.breakLoop
  - Loop.finished -> Done.execIn
"""


@pytest.mark.parametrize(
    "loop", ["omni.graph.action.ForLoop, inputs: {stop: 3}", "WhileLoop, inputs: {condition: true}"]
)
def test_a_break_starts_no_loop(play: Player, loop: str) -> None:
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Never: {{type: IsaacSimulationGate, inputs: {{step: 0}}}}
          Loop: {{type: {loop}}}
          Count: omni.graph.action.Counter
        connections:
          - Tick.tick -> Never.execIn
          - Never.execOut -> Loop.execIn
          - Tick.tick -> Loop.breakLoop
          - Loop.loopBody -> Count.execIn
          - Loop.finished -> Count.execIn
        """
    )
    playing.tick(3)
    assert playing.node("Count").count == 0


def test_in_a_graph_a_break_ends_the_loop_after_the_round(play: Player) -> None:
    playing = play.graph(LOOP)
    playing.tick(3)
    assert (playing.node("Body").count, playing.node("Done").count, playing.node("Loop").value) == (3, 3, 10)


def test_in_a_graph_the_body_runs_for_each_number(play: Player) -> None:
    playing = play.graph(LOOP.replace("  - Body.execOut -> Loop.breakLoop\n", ""))
    playing.tick(2)
    assert (playing.node("Body").count, playing.node("Done").count, playing.node("Loop").value) == (8, 2, 13)


def test_in_a_graph_the_type_of_an_element_follows_from_the_array(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Each: {type: ForEach, inputs: {arrayIn: {type: "double[3][]", value: [[1, 2, 3], [4, 5, 6]]}}}
          Break: BreakVector3
          Odometry: {type: PublishOdometry}
        connections:
          - Tick.tick -> Each.execIn
          - Each.element -> Break.tuple
          - Each.loopBody -> Odometry.execIn
          - Each.element -> Odometry.position
        """
    )
    playing.tick()
    positions = [m.pose.pose.position for m in playing.published(playing.topics["Odometry"])]
    assert [(p.x, p.y, p.z) for p in positions] == [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]


def test_a_loop_without_end_is_told_with_its_node(play: Player) -> None:
    playing = play.graph(
        LOOP.replace("stop: 14", "stop: 2000000000").replace("  - Body.execOut -> Loop.breakLoop\n", "")
    )
    with pytest.raises(NodeError, match=r"node Loop .*ran on after 100000 iterations"):
        playing.tick()


WHILE = """
variables: {go: {type: bool, default: true}}
nodes:
  Tick: OnPlaybackTick
  Open: {type: WriteVariable, inputs: {variableName: go, value: true}}
  Order: Multisequence
  While: WhileLoop
  Body: Counter
  Every: {type: SimulationGate, inputs: {step: 3}}
  Close: {type: WriteVariable, inputs: {variableName: go, value: false}}
  Go: {type: ReadVariable, inputs: {variableName: go}}
  Done: Counter
connections:
  - Tick.tick -> Order.execIn
  - Order.output0 -> Open.execIn
  - Order.output1 -> While.execIn
  - Go.value -> While.condition
  - While.loopBody -> Body.execIn
  - Body.execOut -> Every.execIn
  - Every.execOut -> Close.execIn
  - While.finished -> Done.execIn
"""


def test_while_goes_on_until_its_body_makes_the_condition_false(play: Player) -> None:
    playing = play.graph(WHILE)
    playing.tick(2)
    assert [playing.node(name).count for name in ("Body", "Done")] == [6, 2]
    assert playing.node("While").index == 3


def test_while_ends_after_a_break(play: Player) -> None:
    playing = play.graph(WHILE.replace("Every.execOut -> Close.execIn", "Every.execOut -> While.breakLoop"))
    playing.tick()
    assert [playing.node(name).count for name in ("Body", "Done")] == [3, 1]


def test_while_that_never_holds_finishes_at_once() -> None:
    node = WhileLoop()
    assert list(node.compute()) == [node.finished]


def test_a_condition_straight_from_a_node_of_the_body_is_read_in_each_round(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Flip: FlipFlop
          While: WhileLoop
          Done: Counter
        connections:
          - Tick.tick -> While.execIn
          - While.loopBody -> Flip.execIn
          - Flip.isA -> While.condition
          - While.finished -> Done.execIn
        """
    )
    playing.node("Flip").is_a = True
    playing.tick()
    assert (playing.node("While").index, playing.node("Flip").is_a, playing.node("Done").count) == (1, False, 1)


# Later


def ticks_until_done(playing: Playing, limit: int = 100) -> int:
    for tick in range(1, limit):
        playing.tick()
        if playing.node("Done").count:
            return tick
    raise AssertionError(f"nothing within {limit} ticks")


@pytest.mark.parametrize(
    ("duration", "ticks"), [(0.0, 1), (0.01, 1), (1 / 60, 1), (0.05, 3), (0.1, 6), (0.5, 30), (0.51, 31)]
)
def test_a_delay_fires_in_the_first_tick_at_or_after_its_time(play: Player, duration: float, ticks: int) -> None:
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Start: Once
          Wait: {{type: Delay, inputs: {{duration: {duration!r}}}}}
          Done: Counter
        connections:
          - Tick.tick -> Start.execIn
          - Start.once -> Wait.execIn
          - Wait.finished -> Done.execIn
        """
    )
    assert ticks_until_done(playing) == 1 + ticks


def test_a_delay_that_is_executed_again_waits_anew() -> None:
    context = RecordingContext()
    node = ready(Delay, context, duration=0.1)
    for _ in range(20):
        context.tick()
        node.compute()
        assert node.update() is None
    ticks = 0
    while node.active:
        context.tick()
        ticks += 1
        node.update()
    assert ticks == 5  # its output is executed in the pass after


def test_a_countdown_fires_every_period_and_at_its_end() -> None:
    node: Any = Countdown(duration=5, period=2)
    seen = []
    node.compute()
    while node.active:
        ports = node.update()
        seen.append((node.tick_value, node.alpha, bool(ports & node.tick), bool(ports & node.finished)))
    assert seen == [
        (1, 0.2, False, False),
        (2, 0.4, True, False),
        (3, 0.6, False, False),
        (4, 0.8, True, False),
        (5, 1.0, False, True),
    ]
    assert node.count == -1


def test_a_countdown_in_a_graph_ticks_once_a_tick(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Start: Once
          Down: {type: Countdown, inputs: {duration: 4}}
          Ticks: Counter
          Done: Counter
        connections:
          - Tick.tick -> Start.execIn
          - Start.once -> Down.execIn
          - Down.tick -> Ticks.execIn
          - Down.finished -> Done.execIn
        """
    )
    assert ticks_until_done(playing) == 5
    assert playing.node("Ticks").count == 4


# Custom events


def test_every_event_sent_is_seen_once_in_the_next_tick_with_its_path(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Loop: {type: ForLoop, inputs: {stop: 3}}
          Send: {type: SendCustomEvent, inputs: {eventName: bump, path: /here}}
          Hear: {type: OnCustomEvent, inputs: {eventName: bump}}
          Other: {type: OnCustomEvent, inputs: {eventName: another}}
          Heard: Counter
          Wrong: Counter
        connections:
          - Tick.tick -> Loop.execIn
          - Loop.loopBody -> Send.execIn
          - Hear.execOut -> Heard.execIn
          - Other.execOut -> Wrong.execIn
        """
    )
    counts = []
    for _ in range(3):
        playing.tick()
        counts.append(playing.node("Heard").count)
    assert counts == [0, 3, 6]
    assert (playing.node("Hear").path, playing.node("Wrong").count) == ("/here", 0)


def test_an_event_goes_from_node_to_node() -> None:
    context = RecordingContext()
    sender = ready(SendCustomEvent, context, event_name="e", path="p")
    listener = ready(OnCustomEvent, context, event_name="e")
    sender.compute()
    assert list(listener.compute()) == []
    context.tick()
    assert list(listener.compute()) == [listener.exec_out]
    assert listener.path == "p"
