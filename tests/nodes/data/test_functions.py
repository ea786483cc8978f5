"""Absolute, Clamp, rounding, powers, roots and logarithms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.data.functions import Absolute, Ceil, Clamp, Exponent, Floor, Logarithm, NthRoot, Round
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

REALS = st.floats(-1e6, 1e6)


def test_absolute_values_are_never_negative() -> None:
    assert computed(Absolute, input_in=-2.5).absolute == 2.5
    assert computed(Absolute, input_in=(-1, 2)).absolute == (1, 2)
    assert computed(Absolute, input_in=np.array([-1.0, 2.0])).absolute.tolist() == [1.0, 2.0]


@given(REALS, REALS, REALS)
def test_a_clamped_value_is_between_its_bounds_and_otherwise_itself(value: float, one: float, other: float) -> None:
    lower, upper = sorted((one, other))
    result = computed(Clamp, input_in=value, lower=lower, upper=upper).result
    assert lower <= result <= upper
    assert result == value or not lower <= value <= upper


def test_each_number_of_an_array_is_clamped_by_a_shared_bound_or_its_own() -> None:
    values = np.array([-2.0, 0.5, 9.0])
    assert computed(Clamp, input_in=values, lower=-1.0, upper=1.0).result.tolist() == [-1.0, 0.5, 1.0]
    own = computed(Clamp, input_in=values, lower=np.array([-5.0, 1.0, 1.0]), upper=np.array([0.0, 2.0, 10.0]))
    assert own.result.tolist() == [-2.0, 1.0, 9.0]
    assert computed(Clamp, input_in=(-2.0, 9.0), lower=0.0, upper=(1.0, 2.0)).result == (0.0, 2.0)


@pytest.mark.parametrize("value", [1.0, np.array([1.0, 2.0])])
def test_a_lower_bound_above_the_upper_bound_is_an_error(value: Any) -> None:
    with pytest.raises(ValueError, match="lower, upper must be in ascending order"):
        computed(Clamp, input_in=value, lower=2.0, upper=1.0)


def test_nan_stays_nan_when_clamped() -> None:
    assert math.isnan(computed(Clamp, input_in=math.nan, lower=0.0, upper=1.0).result)


@given(REALS)
def test_floor_and_ceiling_enclose_a_number(value: float) -> None:
    floor, ceiling = computed(Floor, a=value).result, computed(Ceil, a=value).result
    assert floor <= value <= ceiling
    assert ceiling - floor == (0 if value.is_integer() else 1)
    assert {type(floor), type(ceiling)} == {int}


def test_floors_of_tuples_and_arrays_are_ints() -> None:
    assert computed(Floor, a=(-1.5, 1.5)).result == (-2, 1)
    ceilings = computed(Ceil, a=np.array([[-1.5, 1.5]])).result
    assert (ceilings.tolist(), ceilings.dtype) == ([[-1, 2]], np.int32)


@pytest.mark.parametrize(
    ("value", "decimals", "expected"),
    [
        *[(1.2345, 2, 1.23), (1234.5, -2, 1200.0), (1.2345, 400, 1.2345), (12.5, -400, 0.0)],
        *[(2.5, 0, 3.0), (-2.5, 0, -3.0), (0.125, 2, 0.13), (25.0, -1, 30.0)],
        *[(0.49999999999999994, 0, 0.0), (2.0**53 - 1, 0, 2.0**53 - 1)],
    ],
)
def test_a_number_is_rounded_to_the_given_decimals_with_halves_away_from_0(
    value: float, decimals: int, expected: float
) -> None:
    assert computed(Round, input_in=value, decimals=decimals).output == expected
    assert computed(Round, input_in=(value, 0.0), decimals=decimals).output == (expected, 0.0)


@given(st.floats(0.01, 100.0), st.integers(1, 6))
def test_the_nth_root_of_the_nth_power_is_the_number_itself(value: float, n: int) -> None:
    power = computed(Exponent, base=value, exponent=n).result
    assert computed(NthRoot, value=power, nth_root=n).result == pytest.approx(value, rel=1e-12)


def test_powers_of_whole_numbers_are_doubles_and_may_be_negative() -> None:
    node = typed(Exponent, {"base": "int"}, base=2, exponent=-1)
    assert (node.result, str(node.settled["result"])) == (0.5, "double")
    assert computed(Exponent, base=3.0).result == 9.0
    assert computed(Exponent, base=10.0, exponent=400).result == math.inf


def test_roots_of_negative_numbers_exist_only_for_odd_degrees() -> None:
    assert computed(NthRoot, value=-27.0, nth_root=3).result == pytest.approx(-3.0, rel=1e-15)
    assert computed(NthRoot, value=-32.0, nth_root=5).result == pytest.approx(-2.0, rel=1e-15)
    assert math.isnan(computed(NthRoot, value=-4.0).result)
    assert math.isnan(computed(NthRoot, value=-16.0, nth_root=4).result)
    assert computed(NthRoot, value=4.0, nth_root=0).result == math.inf
    assert computed(NthRoot, value=(9.0, 16.0)).result == (3.0, 4.0)


def test_in_a_graph_a_real_number_out_of_the_range_of_int_is_reported_at_its_node(play: Player) -> None:
    with pytest.raises(CheckError, match="Low: result must be in the range of int"):
        shown(play, "int Low.result", {"Low": "{type: Floor, inputs: {a: 1.0e+12}}"})


@given(st.floats(1e-3, 1e3), st.floats(1.1, 50.0))
def test_the_base_to_the_power_of_a_logarithm_is_the_value(value: float, base: float) -> None:
    assert base ** computed(Logarithm, value=value, base=base).result == pytest.approx(value, rel=1e-12)


def test_powers_of_the_base_have_whole_logarithms() -> None:
    assert [computed(Logarithm, value=10.0**n).result for n in range(-5, 20)] == list(range(-5, 20))
    assert [computed(Logarithm, value=2.0**n, base=2.0).result for n in range(-5, 20)] == list(range(-5, 20))
    node = typed(Logarithm, {"value": "int"}, value=1000)
    assert (node.result, str(node.settled["result"])) == (3.0, "double")
    many = typed(Logarithm, {"value": "float[2][]"}, value=np.array([[1.0, 10.0]], np.float32)).result
    assert (many.tolist(), many.dtype) == ([[0.0, 1.0]], np.float32)


@pytest.mark.parametrize(
    ("inputs", "told"),
    [
        ({"value": 0.0}, "value must be above 0, it is 0.0"),
        ({"value": -2}, "value must be above 0, it is -2"),
        ({"value": np.array([1.0, math.nan])}, "value must be above 0, it is nan"),
        ({"value": 2.0, "base": 1.0}, "base must be above 0 and not 1, it is 1.0"),
    ],
)
def test_the_logarithm_of_0_or_a_negative_number_is_an_error(inputs: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        computed(Logarithm, **inputs)
