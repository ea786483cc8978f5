"""Which type comes out of several, and functions of arrays as functions of port values."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.data.broadcast import common, lift, type_of
from tests.nodes.data.harness import concrete

WIDENED = [
    ("int int", "int"),
    ("uchar int", "int"),
    ("int uint", "uint"),
    ("int64 int", "int64"),
    ("int64 uint64", "uint64"),
    ("int64 half", "half"),
    ("int float", "float"),
    ("half float", "float"),
    ("float double", "double"),
    ("uint64 double", "double"),
    ("timecode timecode", "timecode"),
    ("timecode int", "double"),
    ("timecode float", "double"),
    ("int double[3]", "double[3]"),
    ("double int[3]", "double[3]"),
    ("int64 int[3]", "int[3]"),
    ("timecode float[2]", "double[2]"),
    ("float[] int", "float[]"),
    ("float[] double[3]", "double[3][]"),
    ("double[3][] float", "double[3][]"),
    ("vectorf[3] float", "vectorf[3]"),
    ("vectorf[3] double", "vectord[3]"),
    ("vectorf[3] pointf[3]", "vectorf[3]"),
    ("float colord[4][]", "colord[4][]"),
    ("matrixd[4] int", "matrixd[4]"),
]


@pytest.mark.parametrize(("names", "expected"), WIDENED)
def test_bases_widen_as_in_cpp_and_sizes_broadcast(names: str, expected: str) -> None:
    assert str(common({name: concrete(name) for name in names.split()})) == expected


def test_tuples_of_different_lengths_are_refused_with_the_names_of_their_ports() -> None:
    with pytest.raises(ValueError, match=r"^left is double\[2\] and right is int\[3\]; "):
        common({"left": concrete("double[2]"), "number": concrete("int"), "right": concrete("int[3]")})


VALUES: list[tuple[Any, str]] = [
    (True, "bool"),
    (3, "int"),
    (0.5, "double"),
    ("x", "token"),
    ((1, 2), "int[2]"),
    ((1, 2.5, 3), "double[3]"),
    (("a", "b"), "token[]"),
    ((), "token[]"),
    (np.zeros(2, np.float32), "float[]"),
    (np.zeros((2, 3), np.uint8), "uchar[3][]"),
]


@pytest.mark.parametrize(("value", "expected"), VALUES)
def test_outside_a_graph_the_type_follows_from_the_value(value: Any, expected: str) -> None:
    assert str(type_of(value)) == expected


SHAPES = {"": (), "[3]": (3,), "[]": (4,), "[3][]": (4, 3)}
BASES = {"int": np.int32, "float": np.float32, "double": np.float64}


@st.composite
def operands(draw: st.DrawFn) -> tuple[str, Any, np.ndarray[Any, Any]]:
    """A type, a value of it, and the same as an array whose last axis is that of tuples."""
    base, suffix = draw(st.sampled_from(sorted(BASES))), draw(st.sampled_from(sorted(SHAPES)))
    shape = SHAPES[suffix]
    numbers = draw(st.lists(st.integers(-1000, 1000), min_size=12, max_size=12))
    array = np.array(numbers[: int(np.prod(shape))], BASES[base]).reshape(shape)
    plain = array.tolist()
    value = array if suffix.endswith("[]") else tuple(plain) if suffix else plain
    return f"{base}{suffix}", value, array[:, None] if suffix == "[]" else array


@given(operands(), operands(), st.sampled_from([operator.add, operator.sub, operator.mul]))
def test_broadcasting_is_that_of_numpy_with_an_axis_for_tuples(one: Any, other: Any, function: Any) -> None:
    (name, value, array), (other_name, other_value, other_array) = one, other
    inputs = [concrete(name), concrete(other_name)]
    output = common({"a": inputs[0], "b": inputs[1]})
    result = lift(function, inputs, output, function)(value, other_value)
    expected = function(array.astype(np.float64), other_array.astype(np.float64))
    if output.array:
        assert result.dtype == output.dtype
        assert result.shape == ((4,) if output.count == 1 else (4, 3))
        np.testing.assert_array_equal(result.reshape(expected.shape), expected)
    else:
        np.testing.assert_array_equal(np.array(result), expected)
        number = int if output.base == "int" else float
        assert {type(part) for part in (result if output.count > 1 else (result,))} == {number}


WRAPPED = [("uchar", 200, 100, 44), ("int", 2**31 - 1, 1, -(2**31)), ("uint", 0, -1, 2**32 - 1)]


@pytest.mark.parametrize(("base", "a", "b", "expected"), [*WRAPPED, ("uint64", 2**64 - 1, 2, 1)])
def test_single_integers_wrap_around_like_integers_in_arrays(base: str, a: int, b: int, expected: int) -> None:
    one, many = concrete(base), concrete(f"{base}[]")
    assert lift(operator.add, [one, one], one, operator.add)(a, b) == expected
    arrays = [np.array([number % 2**64], np.uint64).astype(one.dtype) for number in (a, b)]
    assert lift(operator.add, [many, many], many)(*arrays).tolist() == [expected]


def test_real_numbers_of_an_array_are_rounded_once() -> None:
    floats = concrete("float[]")
    a, b = np.array([0.1, 1.0e38], np.float32), np.array([0.2, 1.0e38], np.float32)
    np.testing.assert_array_equal(lift(operator.add, [floats, floats], floats)(a, b), a + b)


def test_single_floats_and_tuples_keep_the_precision_of_a_double() -> None:
    one, three = concrete("half"), concrete("half[3]")
    assert lift(operator.mul, [one, one], one, operator.mul)(0.1, 2.0) == 0.2
    assert lift(operator.mul, [three, one], three, operator.mul)((0.1, 0.25, 0.5), 2.0) == (0.2, 0.5, 1.0)


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), 3.0e9])
def test_a_real_number_out_of_the_range_of_an_integer_is_an_error(wrong: float) -> None:
    with pytest.raises(ValueError, match=r"result must be in the range of int, -2147483648 to 2147483647"):
        lift(np.floor, [concrete("double")], concrete("int"))(wrong)


def test_arrays_of_different_lengths_are_an_error() -> None:
    doubles = concrete("double[]")
    with pytest.raises(ValueError, match="arrays must be of the same length, or of one element"):
        lift(operator.add, [doubles, doubles], doubles)(np.zeros(3), np.zeros(2))


def test_an_array_of_one_element_combines_with_any_array() -> None:
    doubles = concrete("double[]")
    result = lift(operator.add, [doubles, doubles], doubles)(np.array([1.0]), np.array([1.0, 2.0]))
    assert result.tolist() == [2.0, 3.0]


def test_empty_arrays_stay_empty_and_keep_their_type() -> None:
    one, number = concrete("float[3][]"), concrete("double")
    result = lift(operator.add, [one, number], one)(np.zeros((0, 3), np.float32), 1.0)
    assert (result.shape, result.dtype) == ((0, 3), np.float32)
