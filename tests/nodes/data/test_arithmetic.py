"""Add, Subtract, Multiply, Divide, Modulo, Negate, Increment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import BadValueError
from graphengine.nodes.data.arithmetic import Add, Divide, Increment, Modulo, Multiply, Negate, Subtract
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

REALS = st.floats(-1e6, 1e6)


def test_arithmetic_nodes_are_data_nodes() -> None:
    assert {cls.kind() for cls in (Add, Subtract, Multiply, Divide, Modulo, Negate, Increment)} == {"data"}


def test_numbers_add_subtract_and_multiply() -> None:
    assert computed(Add, a=1.5, b=2.0).sum == 3.5
    assert computed(Subtract, a=1.5, b=2.0).difference == -0.5
    assert computed(Multiply, a=1.5, b=2.0).product == 3.0


def test_tuples_and_arrays_add_number_by_number() -> None:
    assert computed(Add, a=(1.0, 2.0, 3.0), b=1.0).sum == (2.0, 3.0, 4.0)
    assert computed(Add, a=(1, 2), b=(10, 20)).sum == (11, 22)
    assert computed(Add, a=np.array([[1.0, 2.0], [3.0, 4.0]]), b=(10.0, 20.0)).sum.tolist() == [[11, 22], [13, 24]]


@given(REALS, REALS)
def test_adding_and_subtracting_a_value_leaves_the_number_unchanged(a: float, b: float) -> None:
    total = computed(Add, a=a, b=b).sum
    assert computed(Subtract, a=total, b=b).difference == pytest.approx(a, abs=1e-9 * (1.0 + abs(a) + abs(b)))


@given(REALS, REALS.filter(lambda b: abs(b) > 1e-6))
def test_multiplying_and_dividing_by_a_value_leaves_the_number_unchanged(a: float, b: float) -> None:
    assert computed(Divide, a=computed(Multiply, a=a, b=b).product, b=b).result == pytest.approx(a, rel=1e-12)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ("int", "double", "double"),
        ("float", "int", "float"),
        ("vectorf[3]", "double", "vectord[3]"),
        ("int[]", "int", "int[]"),
    ],
)
def test_the_sum_has_the_wider_type_of_its_operands(a: str, b: str, expected: str) -> None:
    values: dict[str, Any] = {
        "int": 1,
        "double": 0.5,
        "float": 0.5,
        "vectorf[3]": (1.0, 2.0, 3.0),
        "int[]": np.arange(2),
    }
    assert str(typed(Add, {"a": a, "b": b}, a=values[a], b=values[b]).settled["sum"]) == expected


def test_in_a_graph_a_whole_literal_takes_the_type_of_the_wire(play: Player) -> None:
    nodes = {"Half": "{type: ConstantFloat, inputs: {value: 0.5}}", "Sum": "{type: Add, inputs: {b: 1}}"}
    assert shown(play, "float Sum.sum", nodes, ["Half.inputs:value -> Sum.a"]) == 1.5


def test_in_a_graph_whole_literals_stay_whole_and_feed_doubles_too(play: Player) -> None:
    nodes = {"Sum": "{type: Add, inputs: {a: 1, b: 2}}"}
    assert repr(shown(play, "int Sum.sum", nodes)) == "3"
    assert repr(shown(play, "double Sum.sum", nodes)) == "3.0"


def test_in_a_graph_naming_a_further_input_adds_it(play: Player) -> None:
    nodes = {
        "Ten": "{type: ConstantDouble, inputs: {value: 10}}",
        "Sum": "{type: Add, inputs: {a: 1, b: 2, input2: [1, 2]}}",
        "Rest": "{type: Subtract, inputs: {a: 100, b: 2}}",
        "Product": "{type: Multiply, inputs: {b: 2, input2: 3, input10: 5}}",
    }
    wires = ["Ten.inputs:value -> Sum.input3", "Ten.inputs:value -> Rest.input2", "Rest.difference -> Product.a"]
    assert shown(play, "double[2] Sum.sum", nodes, wires) == (14.0, 15.0)
    assert shown(play, "double Product.product", nodes, wires) == 2640.0


def test_in_a_graph_the_sum_follows_its_inputs(play: Player) -> None:
    playing = play.graph(
        """
        variables: {total: {type: int64, default: 0}}
        nodes:
          Tick: OnPlaybackTick
          Count: Counter
          Total: {type: ReadVariable, inputs: {variableName: total}}
          Sum: Add
          Write: {type: WriteVariable, inputs: {variableName: total}}
        connections:
          - Tick.tick -> Count.execIn
          - Count.execOut -> Write.execIn
          - Count.count -> Sum.a
          - Total.value -> Sum.b
          - Sum.sum -> Write.value
        """
    ).tick(4)
    assert playing.node("Write").value_out == 1 + 2 + 3 + 4


def test_in_a_graph_tuples_of_different_lengths_are_reported_with_both_ports(play: Player) -> None:
    with pytest.raises(CheckError, match=r"G206: Sum: a is int\[2\] and b is double\[3\]; "):
        shown(play, "double Sum.sum", {"Sum": "{type: Add, inputs: {a: [1, 2], b: [0.5, 1, 2]}}"})


def test_in_a_graph_operands_that_are_not_numbers_give_a_short_error(play: Player) -> None:
    nodes = {"Text": "{type: ConstantString, inputs: {value: x}}", "Sum": "{type: Add, inputs: {b: 1}}"}
    with pytest.raises(
        CheckError, match=r"Text\.value is a string, Sum\.a takes an int \| int64 \| .{,90} more"
    ) as told:
        shown(play, "double Sum.sum", nodes, ["Text.inputs:value -> Sum.a"])
    assert len(str(told.value)) < 500


# Division


def test_whole_numbers_divide_to_a_double() -> None:
    node = typed(Divide, {"a": "int", "b": "int"}, a=3, b=2)
    assert (node.result, str(node.settled["result"])) == (1.5, "double")
    assert str(typed(Divide, {"a": "int[3]", "b": "int"}, a=(1, 2, 3), b=2).settled["result"]) == "double[3]"


def test_a_quotient_has_the_type_of_a_real_numerator() -> None:
    node = typed(Divide, {"a": "float[]", "b": "double"}, a=np.array([1.0, 2.0], np.float32), b=4.0)
    assert (node.result.dtype, node.result.tolist()) == (np.float32, [0.25, 0.5])


@pytest.mark.parametrize(("a", "b"), [(1.0, 0.0), (1, 0), (np.ones(2), np.array([1.0, 0.0])), ((1.0, 2.0), 0.0)])
def test_division_by_zero_is_an_error(a: Any, b: Any) -> None:
    with pytest.raises(BadValueError, match="b must be other than 0"):
        computed(Divide, a=a, b=b)


def test_in_a_graph_division_by_zero_keeps_the_previous_quotient(play: Player) -> None:
    playing = play.graph(
        """
        nodes:
          Tick: {type: OnTick}
          Below: {type: Subtract, inputs: {b: 2}}
          Ratio: {type: Divide, inputs: {a: 1.0}}
          Wait: Delay
        connections:
          - Tick.tick -> Wait.execIn
          - Tick.frame -> Below.a
          - Below.difference -> Ratio.b
          - Ratio.result -> Wait.duration
        """
    ).tick()
    playing.tick()
    assert playing.node("Ratio").result == -1.0
    assert playing.dropped == {"/World/graph/Ratio": 1}


@pytest.mark.parametrize("b", ["[1, 2]", "{type: 'double[]', value: [1, 2]}"])
def test_in_a_graph_a_number_is_divided_by_a_number(play: Player, b: str) -> None:
    with pytest.raises(CheckError, match=r"Ratio: a is double and b is .*; b must be one number"):
        shown(play, "double Ratio.result", {"Ratio": f"{{type: Divide, inputs: {{a: 1.5, b: {b}}}}}"})


@given(st.integers(-100, 100), st.integers(-100, 100).filter(bool))
def test_the_remainder_belongs_to_the_quotient_rounded_toward_zero(a: int, b: int) -> None:
    assert computed(Modulo, a=a, b=b).result == a - b * math.trunc(a / b) == math.fmod(a, b)


def test_a_remainder_by_zero_is_zero() -> None:
    assert computed(Modulo, a=7, b=0).result == 0


# Others


def test_a_value_is_negated() -> None:
    assert computed(Negate, input_in=(1.0, -2.0)).output == (-1.0, 2.0)
    assert computed(Negate, input_in=np.array([1, -2], np.int32)).output.tolist() == [-1, 2]


def test_in_a_graph_unsigned_numbers_are_not_negated(play: Player) -> None:
    nodes = {"Whole": "ConstantUInt", "Minus": "Negate"}
    with pytest.raises(CheckError, match="Minus: input is uint, which has no negative numbers"):
        shown(play, "double Minus.output", nodes, ["Whole.inputs:value -> Minus.input"])


def test_an_increment_keeps_the_type_and_truncates() -> None:
    assert computed(Increment, value=4).result == 5
    assert repr(computed(Increment, value=4, increment=3.2).result) == "7"  # the documentation's example
    assert computed(Increment, value=-4, increment=0.5).result == -3
    assert computed(Increment, value=2**31 - 1, increment=0.5).result == 2**31 - 1
    assert typed(Increment, {"value": "int64"}, value=2**60 + 1).result == 2**60 + 2
    assert computed(Increment, value=(1.0, 2.0), increment=0.5).result == (1.5, 2.5)
    whole = typed(Increment, {"value": "int[]"}, value=np.array([1, 2], np.int32), increment=1.9).result
    assert (whole.tolist(), whole.dtype) == ([2, 3], np.int32)
