"""Compare, IsZero, AnyZero and EachZero."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.data.comparison import AnyZero, Compare, EachZero, IsZero
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

OPERATIONS = {">": operator.gt, "<": operator.lt, ">=": operator.ge}
OPERATIONS |= {"<=": operator.le, "==": operator.eq, "!=": operator.ne}


@given(st.integers(-3, 3), st.integers(-3, 3), st.sampled_from(sorted(OPERATIONS)))
def test_numbers_of_different_types_compare_by_value(a: int, b: int, operation: str) -> None:
    expected = OPERATIONS[operation](a, b)
    assert computed(Compare, a=a, b=float(b), operation=operation).result is expected
    array = typed(
        Compare, {"a": "uchar[]", "b": "double"}, a=np.array([a + 3], np.uint8), b=b + 3.0, operation=operation
    )
    assert array.result.tolist() == [expected]
    assert array.result.dtype == np.bool_


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((1, 9), (2, 0), [False, True, False, True]),
        ((1, 2), (1, 1), [True, False, True, False]),
        ("b", "a", [True, False, True, False]),
        ("a", "a", [False, False, True, True]),
    ],
)
def test_tuples_and_texts_compare_by_their_first_difference(a: Any, b: Any, expected: list[bool]) -> None:
    assert [computed(Compare, a=a, b=b, operation=operation).result for operation in (">", "<", ">=", "<=")] == expected


def test_a_single_value_is_compared_with_each_of_an_array() -> None:
    pairs = np.array([[1.0, 2.0], [1.0, 3.0], [0.0, 9.0]])
    assert computed(Compare, a=pairs, b=(1.0, 2.0)).result.tolist() == [False, True, False]
    assert computed(Compare, a=(1.0, 2.0), b=pairs, operation="==").result.tolist() == [True, False, False]
    assert computed(Compare, a=("a", "b"), b="b", operation="==").result.tolist() == [False, True]
    assert computed(Compare, a=np.arange(3), b=np.array([2, 1, 0]), operation="<").result.tolist() == [
        True,
        False,
        False,
    ]
    assert computed(Compare, a=np.zeros((0, 2)), b=(1.0, 2.0)).result.tolist() == []


def test_comparing_arrays_of_different_lengths_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"a, b must be of the same length, it is \[2, 3\]"):
        computed(Compare, a=np.zeros((2, 2)), b=np.zeros((3, 2)))


@pytest.mark.parametrize("b", ["[1, 2]", "{type: token, value: x}", "{type: 'token[]', value: [x]}"])
def test_in_a_graph_types_that_do_not_compare_are_reported_with_both_ports(play: Player, b: str) -> None:
    with pytest.raises(CheckError, match=r"Is: a is double and b is .*, which cannot be compared"):
        shown(play, "bool Is.result", {"Is": f"{{type: Compare, inputs: {{a: 1.5, b: {b}}}}}"})


def test_in_a_graph_the_result_is_a_scalar_or_has_one_element_per_pair(play: Player) -> None:
    assert shown(play, "bool Is.result", {"Is": "{type: Compare, inputs: {a: 2, b: 1.5}}"}) is True
    nodes = {"Is": "{type: Compare, inputs: {a: {type: 'int[]', value: [1, 2]}, b: 2, operation: '=='}}"}
    assert shown(play, "bool[] Is.result", nodes).tolist() == [False, True]


def test_in_a_graph_an_unknown_operation_is_refused_with_the_six_legal_operations(play: Player) -> None:
    with pytest.raises(CheckError, match=r"Is\.operation: expected one of >, <, >=, <=, ==, !="):
        shown(play, "bool Is.result", {"Is": "{type: Compare, inputs: {a: 2, b: 1, operation: '=>'}}"})


def test_an_unknown_operation_from_a_wire_is_reported(play: Player) -> None:
    nodes = {"Is": "{type: Compare, inputs: {a: 2, b: 1}}", "Word": "{type: ConstantToken, inputs: {value: '=>'}}"}
    with pytest.raises(CheckError, match="Is: operation must be one of >, <, >=, <=, ==, !=, it is '=>'"):
        shown(play, "bool Is.result", nodes, ["Word.inputs:value -> Is.operation"])


ZEROS: list[tuple[Any, bool, bool, Any]] = [
    (0.0, True, True, True),
    (0.1, False, False, False),
    ((3.0, 0.0, 1.0), False, True, [False, True, False]),  # as in the documentation
    (np.array([[3, 0, 1], [-5, 4, 17]]), False, False, [False, False]),  # as in the documentation
    (np.array([[0, 0], [1, 0]]), False, True, [True, False]),
    (np.zeros(2), True, True, [True, True]),
    ((0, 0), True, True, [True, True]),
]


@pytest.mark.parametrize(("value", "every", "some", "each"), ZEROS)
def test_is_zero_any_zero_and_each_zero_find_the_zeros_of_a_value(
    value: Any, every: bool, some: bool, each: Any
) -> None:
    assert (computed(IsZero, value=value).result, computed(AnyZero, value=value).result) == (every, some)
    found = computed(EachZero, value=value).result
    assert (found.tolist() if isinstance(found, np.ndarray) else found) == each


def test_numbers_within_the_tolerance_count_as_zero() -> None:
    assert computed(IsZero, value=(-0.25, 0.5), tolerance=0.5).result is True
    assert computed(IsZero, value=(-0.25, 0.5), tolerance=0.4).result is False
    assert computed(EachZero, value=1, tolerance=1.0).result is True


def test_in_a_graph_each_zero_outputs_a_bool_for_each_number_of_a_tuple(play: Player) -> None:
    assert shown(play, "bool[] Each.result", {"Each": "{type: EachZero, inputs: {value: [0, 1]}}"}).tolist() == [
        True,
        False,
    ]
    assert shown(play, "bool Each.result", {"Each": "{type: EachZero, inputs: {value: 0}}"}) is True
