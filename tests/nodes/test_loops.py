"""Loops: alone, and in graphs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from graphengine.format.errors import NodeError
from graphengine.nodes.action.loops import ForEach, ForEachTarget, ForLoop, WhileLoop
from tests.nodes.harness import Player

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
def test_a_for_loop_outputs_start_to_stop_exclusive_in_steps(start: int, stop: int, step: int) -> None:
    node = ForLoop(start=start, stop=stop, step=step)
    expected, index = [], 0
    while (start + step * index < stop) if step > 0 else (start + step * index > stop):
        expected.append(("body", index, start + step * index))
        index += 1
    seen = list(rounds(node, "index", "value"))
    assert seen[:-1] == expected
    assert seen[-1] == ("finished", *(expected[-1][1:] if expected else (0, 0)))


def test_a_step_of_zero_is_an_error() -> None:
    with pytest.raises(ValueError, match="step must be other than 0"):
        list(ForLoop(stop=3, step=0).compute())


def test_a_loop_with_a_break_finishes_after_the_current_iteration() -> None:
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
def test_for_each_outputs_every_element_as_a_port_value(array: Any, elements: list[Any]) -> None:
    node = ForEach(array_in=array)
    seen = list(rounds(node, "array_index", "element"))
    assert seen[:-1] == [("body", index, element) for index, element in enumerate(elements)]
    assert all(type(one[2]) is type(other) for one, other in zip(seen, elements, strict=False))
    assert seen[-1][0] == "finished"


def test_for_each_target_outputs_every_prim_separately() -> None:
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
    ).tick(3)
    assert playing.node("Count").count == 0


def test_in_a_graph_a_break_ends_the_loop_after_the_current_iteration(play: Player) -> None:
    playing = play.graph(LOOP).tick(3)
    assert (playing.node("Body").count, playing.node("Done").count, playing.node("Loop").value) == (3, 3, 10)


def test_in_a_graph_the_body_runs_for_each_number(play: Player) -> None:
    playing = play.graph(LOOP.replace("  - Body.execOut -> Loop.breakLoop\n", "")).tick(2)
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
    ).tick()
    positions = [m.pose.pose.position for m in playing.published(playing.topics["Odometry"])]
    assert [(p.x, p.y, p.z) for p in positions] == [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]


def test_an_endless_loop_is_an_error_that_names_its_node(play: Player) -> None:
    playing = play.graph(
        LOOP.replace("stop: 14", "stop: 2000000000").replace("  - Body.execOut -> Loop.breakLoop\n", "")
    )
    with pytest.raises(NodeError, match=r"node Loop .*start, stop, step must be a range of 100000 numbers or fewer"):
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


def test_a_while_loop_runs_until_its_body_makes_the_condition_false(play: Player) -> None:
    playing = play.graph(WHILE).tick(2)
    assert [playing.node(name).count for name in ("Body", "Done")] == [6, 2]
    assert playing.node("While").index == 2, "number of the last round"


def test_a_while_loop_ends_after_a_break(play: Player) -> None:
    playing = play.graph(WHILE.replace("Every.execOut -> Close.execIn", "Every.execOut -> While.breakLoop")).tick()
    assert [playing.node(name).count for name in ("Body", "Done")] == [3, 1]


def test_a_while_loop_with_a_false_condition_finishes_at_once() -> None:
    node = WhileLoop()
    assert list(node.compute()) == [node.finished]


def test_a_condition_wired_from_the_loop_body_is_read_before_each_iteration(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Flip: FlipFlop, While: WhileLoop, Done: Counter}
        connections:
          - Tick.tick -> While.execIn
          - While.loopBody -> Flip.execIn
          - Flip.isA -> While.condition
          - While.finished -> Done.execIn
        """
    )
    playing.node("Flip").is_a = True
    playing.tick()
    assert (playing.node("While").index, playing.node("Flip").is_a, playing.node("Done").count) == (0, False, 1)
