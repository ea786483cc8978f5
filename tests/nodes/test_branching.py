"""Branch, Sequence, Multisequence and SwitchToken: alone, and in graphs."""

from __future__ import annotations

import pytest

from graphengine.nodes.action.branching import Branch, Multisequence, Sequence, SwitchToken
from graphengine.testing import RecordingContext
from tests.nodes.firing import fired, of
from tests.nodes.harness import Player

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


def test_a_multisequence_has_the_wired_outputs_and_fires_them_in_the_order_of_their_numbers() -> None:
    node = of(Multisequence, "output10", "output2", "output1")
    assert list(node.compute()) == [node.output0, node.output1, node.output2, node.output10]


def test_the_nodes_behind_an_output_of_a_multisequence_finish_before_the_next_output_fires(play: Player) -> None:
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Both: Multisequence, First: Counter, Second: Counter, Reset: Counter}
        connections:
          - Tick.tick -> Both.execIn
          - Both.output2 -> Second.reset
          - Both.output0 -> First.execIn
          - First.execOut -> Second.execIn
          - Both.output1 -> Second.execIn
          - Second.execOut -> Reset.execIn
        """
    ).tick(2)
    assert [playing.node(name).count for name in ("First", "Second", "Reset")] == [2, 0, 6]


# SwitchToken


def test_a_switch_fires_the_output_of_the_branch_that_has_the_value() -> None:
    node = of(SwitchToken, "output0", "output1", branch0="stop", branch1="go", value="go")
    assert fired(node) == "output1"
    node.value = "stop"
    assert fired(node) == "output0"


def test_a_switch_accepts_the_two_digit_numbers_of_isaac_sims_editor(play: Player) -> None:
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
    ).tick(2)
    assert (playing.node("Hit").count, playing.node("Miss").count) == (2, 0)


def test_a_switch_without_a_matching_branch_fires_nothing() -> None:
    node = of(SwitchToken, "output0", branch0="stop", value="go")
    assert fired(node) == ""
    node.value = "Stop"
    assert fired(node) == ""


def test_a_switch_whose_branch_has_no_output_fires_nothing() -> None:
    assert fired(of(SwitchToken, branch0="a", value="a")) == ""


def test_of_two_branches_with_the_value_the_lower_number_wins() -> None:
    assert fired(of(SwitchToken, "output10", "output9", branch10="a", branch9="a", value="a")) == "output9"
