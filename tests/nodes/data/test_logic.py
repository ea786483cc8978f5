"""Truth values joined: BooleanAnd, Or, Nand, Nor, Not and BooleanExpr."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.node import Node
from graphengine.nodes.data.logic import BooleanAnd, BooleanExpr, BooleanNand, BooleanNor, BooleanNot, BooleanOr
from tests.nodes.data.harness import computed, shown
from tests.nodes.harness import Player

GATES: dict[type[Node], Callable[[list[bool]], bool]] = {
    BooleanAnd: all,
    BooleanOr: any,
    BooleanNand: lambda values: not all(values),
    BooleanNor: lambda values: not any(values),
}
WORDS = {"AND": "TFFF", "OR": "TTTF", "NAND": "FTTT", "NOR": "FFFT", "XOR": "FTTF", "XNOR": "TFFT"}
PAIRS = [(True, True), (True, False), (False, True), (False, False)]


@pytest.mark.parametrize("cls", GATES)
def test_gates_combine_booleans(cls: Any) -> None:
    assert [computed(cls, a=a, b=b).result for a, b in PAIRS] == [GATES[cls]([a, b]) for a, b in PAIRS]


@given(st.sampled_from(list(GATES)), st.lists(st.booleans(), min_size=3, max_size=3), st.booleans())
def test_gates_combine_arrays_element_by_element(cls: Any, many: list[bool], one: bool) -> None:
    expected = [GATES[cls]([element, one]) for element in many]
    joined = computed(cls, a=np.array(many), b=one).result
    assert (joined.tolist(), joined.dtype) == (expected, np.bool_)
    assert computed(cls, a=np.array(many), b=np.array([one] * 3)).result.tolist() == expected


@pytest.mark.parametrize("cls", GATES)
def test_in_a_graph_further_inputs_are_combined_from_left_to_right(play: Player, cls: Any) -> None:
    text = f"{{type: {cls.__name__}, inputs: {{a: true, b: true, input2: false}}}}"
    assert shown(play, "bool Gate.result", {"Gate": text}) is GATES[cls]([True, True, False])


def test_boolean_not_inverts_booleans_and_arrays() -> None:
    assert [computed(BooleanNot, value_in=value).value_out for value in (True, False)] == [False, True]
    assert computed(BooleanNot, value_in=np.array([True, False])).value_out.tolist() == [False, True]


@pytest.mark.parametrize("word", WORDS)
def test_a_boolean_expression_applies_its_operator(word: str) -> None:
    joined = [computed(BooleanExpr, a=a, b=b, operator_in=word).result for a, b in PAIRS]
    assert joined == [letter == "T" for letter in WORDS[word]]


def test_the_default_operator_of_a_boolean_expression_is_and() -> None:
    assert computed(BooleanExpr, a=True, b=True).result is True
    assert computed(BooleanExpr, a=True).result is False


def test_in_a_graph_an_unknown_operator_is_reported_with_the_legal_operators(play: Player) -> None:
    with pytest.raises(CheckError, match="Is: operator must be one of AND, OR, XOR, XNOR, NAND, NOR, it is 'and'"):
        shown(play, "bool Is.result", {"Is": "{type: BooleanExpr, inputs: {operator: and}}"})


def test_in_a_graph_numbers_are_refused_as_booleans(play: Player) -> None:
    with pytest.raises(CheckError, match=r"Gate\.a is a bool \| bool\[\].*got 1"):
        shown(play, "bool Gate.result", {"Gate": "{type: BooleanAnd, inputs: {a: 1, b: true}}"})
