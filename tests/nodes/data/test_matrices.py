"""Matrices put together, taken apart and multiplied."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.data import matrices
from graphengine.nodes.data.matrices import InvertMatrix, MakeMatrix4, MatrixMultiply, TransformVector, Transpose
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

NUMBERS = np.random.default_rng(1).integers(-9, 9, (3, 4, 4)).astype(np.float64)
LARGEST_FLOAT = 3.4028234663852886e38


def rows(matrix: np.ndarray[Any, Any]) -> tuple[float, ...]:
    return tuple(matrix.ravel().tolist())


@pytest.mark.parametrize("size", [2, 3, 4])
def test_a_matrix_is_built_from_rows_and_split_into_them(size: int) -> None:
    names, square = "xyzw"[:size], NUMBERS[0, :size, :size]
    make, take = (getattr(matrices, f"{what}Matrix{size}") for what in ("Make", "Break"))
    made = computed(make, **{name: rows(row) for name, row in zip(names, square, strict=True)})
    assert made.matrix == rows(square)
    broken = typed(take, {"matrix": f"matrixd[{size}]"}, matrix=made.matrix)
    assert [getattr(broken, name) for name in names] == [rows(row) for row in square]
    many = typed(take, {"matrix": f"matrixd[{size}][]"}, matrix=NUMBERS[:, :size, :size].reshape(3, -1))
    assert getattr(many, names[1]).tolist() == NUMBERS[:, 1, :size].tolist()


def test_rows_of_three_numbers_get_the_fourth_column_0_0_0_1() -> None:
    made = computed(
        MakeMatrix4, x=(1.0, 0.0, 0.0), y=(0.0, 1.0, 0.0), z=(0.0, 0.0, 1.0), w=np.array([[5.0, 6.0, 7.0]] * 2)
    )
    expected = np.eye(4)
    expected[3, :3] = 5.0, 6.0, 7.0
    assert made.matrix.tolist() == [expected.ravel().tolist()] * 2


def test_in_a_graph_the_output_type_sets_the_length_of_rows(play: Player) -> None:
    text = "{type: ConstantMatrix4d, inputs: {value: [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12], [13, 14, 15, 16]]}}"
    for given_type, expected in (("double[4]", (13.0, 14.0, 15.0, 16.0)), ("double[3]", (13.0, 14.0, 15.0))):
        nodes = {"Matrix": text, "Break": f"{{type: BreakMatrix4, inputs: {{outputType: '{given_type}'}}}}"}
        assert shown(play, f"{given_type} Break.w", nodes, ["Matrix.inputs:value -> Break.matrix"]) == expected


FACTORS = [
    ("matrixd[3]", "matrixd[3]", "matrixd[3]"),
    ("double[3]", "matrixd[3]", "double[3]"),
    ("matrixd[3]", "vectorf[3]", "vectord[3]"),
    ("float[3]", "float[3]", "float"),
    ("matrixd[3][]", "matrixd[3]", "matrixd[3][]"),
    ("vectord[3]", "matrixd[3][]", "double[3][]"),
    ("double[3][]", "double[3]", "double[]"),
    ("frame[4]", "frame[4]", "frame[4]"),
    ("frame[4]", "matrixd[4]", "matrixd[4]"),
]


def factor(port_type: str, seed: int) -> tuple[Any, np.ndarray[Any, Any]]:
    """A value of a type, and the same as numpy's matmul takes it, with an axis for arrays."""
    size = int(port_type[port_type.index("[") + 1])
    is_matrix, many = port_type.startswith(("matrixd", "frame")), port_type.endswith("[]")
    shape = (size, size) if is_matrix else (size,)
    numbers = np.random.default_rng(seed).integers(-9, 9, ((2, *shape) if many else shape)).astype(np.float64)
    return (numbers.reshape(2, -1) if many else rows(numbers)), numbers


@pytest.mark.parametrize(("a", "b", "expected"), FACTORS)
def test_matrices_rows_and_columns_multiply_as_in_numpy(a: str, b: str, expected: str) -> None:
    (value, one), (other_value, other) = factor(a, 1), factor(b, 2)
    node = typed(MatrixMultiply, {"a": a, "b": b}, a=value, b=other_value)
    assert str(node.settled["output"]) == expected
    column = other[..., None] if not b.startswith(("matrixd", "frame")) else other
    row = one[..., None, :] if not a.startswith(("matrixd", "frame")) else one
    product = row @ column
    np.testing.assert_array_equal(np.ravel(node.output), np.ravel(product))


def test_in_a_graph_factors_of_mismatched_sizes_are_reported_with_both_ports(play: Player) -> None:
    nodes = {"M": "ConstantMatrix3d", "V": "ConstantDouble2", "Product": "MatrixMultiply"}
    with pytest.raises(
        CheckError, match=r"Product: a is matrixd\[3\] and b is double\[2\]; a must have as many columns"
    ):
        shown(play, "double Product.output", nodes, ["M.inputs:value -> Product.a", "V.inputs:value -> Product.b"])


def test_transpose_exchanges_rows_and_columns() -> None:
    square = NUMBERS[0, :3, :3]
    assert computed(Transpose, matrix=rows(square)).result == rows(square.T)
    assert (
        computed(Transpose, matrix=NUMBERS.reshape(3, 16)).result.tolist()
        == np.swapaxes(NUMBERS, 1, 2).reshape(3, 16).tolist()
    )


@given(st.integers(0, 1000), st.integers(2, 4))
def test_a_matrix_times_its_inverse_is_the_identity(seed: int, size: int) -> None:
    square = np.random.default_rng(seed).normal(size=(size, size)) + 3.0 * np.eye(size)
    inverse = typed(InvertMatrix, {"matrix": f"matrixd[{size}]"}, matrix=rows(square)).inverted_matrix
    bound = 1e-12 * np.linalg.cond(square)
    np.testing.assert_allclose(square @ np.reshape(inverse, (size, size)), np.eye(size), atol=bound)


def test_the_inverse_of_a_singular_matrix_is_the_identity_times_the_largest_float() -> None:
    singular, regular = np.ones((3, 3)), 2.0 * np.eye(3)
    both = computed(InvertMatrix, matrix=np.array([singular.ravel(), regular.ravel()])).inverted_matrix
    assert both[0].tolist() == (LARGEST_FLOAT * np.eye(3)).ravel().tolist()
    assert both[1].tolist() == (0.5 * np.eye(3)).ravel().tolist()


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_matrix_with_nan_counts_as_singular_and_prints_no_warning(
    number: float, capfd: pytest.CaptureFixture[str]
) -> None:
    broken, regular = np.eye(4), 2.0 * np.eye(4)
    broken[1, 2] = number
    both = computed(InvertMatrix, matrix=np.array([broken.ravel(), regular.ravel()])).inverted_matrix
    assert both.tolist() == [(LARGEST_FLOAT * np.eye(4)).ravel().tolist(), (0.5 * np.eye(4)).ravel().tolist()]
    assert capfd.readouterr() == ("", "")


def test_a_matrix_with_four_rows_translates_a_vector() -> None:
    move = np.eye(4)
    move[3, :3] = 10.0, 20.0, 30.0
    assert computed(TransformVector, matrix=rows(move), vector=(1.0, 2.0, 3.0)).result == (11.0, 22.0, 33.0)
    many = computed(TransformVector, matrix=rows(move), vector=np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])).result
    assert many.tolist() == [[10.0, 20.0, 30.0], [11.0, 21.0, 31.0]]
    move[3, 3] = 2.0
    assert computed(TransformVector, matrix=rows(move), vector=(0.0, 0.0, 0.0)).result == (5.0, 10.0, 15.0)


def test_a_matrix_with_three_rows_multiplies_a_row_vector() -> None:
    square = NUMBERS[0, :3, :3]
    node = typed(
        TransformVector,
        {"matrix": "matrixd[3][]", "vector": "vectorf[3]"},
        matrix=square.reshape(1, 9),
        vector=(1.0, 2.0, 3.0),
    )
    assert node.result.tolist() == [(np.array([1.0, 2.0, 3.0]) @ square).tolist()]
    assert node.result.dtype == np.float32
