"""Rotations as quaternions, matrices and angles: each way there and back, and against textbook formulas."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.data.orientation import (
    ORDERS,
    angles_of,
    matrix_about,
    matrix_of_angles,
    matrix_of_quaternions,
    quaternions_of,
    rotation_matrix,
    slerp,
    without_scale,
)
from tests.nodes.harness import matrix

QUATERNIONS = (
    st.tuples(*[st.integers(-100, 100)] * 4).filter(any).map(lambda parts: np.array(parts) / math.hypot(*parts))
)
ANGLES = st.tuples(st.floats(-179.0, 179.0), st.floats(-179.0, 179.0), st.floats(-179.0, 179.0)).map(np.array)
HALF = math.sqrt(0.5)


@given(QUATERNIONS)
def test_the_matrix_of_a_quaternion_is_the_transpose_of_the_textbooks(q: np.ndarray) -> None:
    np.testing.assert_allclose(matrix_of_quaternions(q), matrix(tuple(q.tolist())).T, atol=1e-14)
    np.testing.assert_allclose(matrix_of_quaternions(3.0 * q), matrix(tuple(q.tolist())).T, atol=1e-14)


@given(QUATERNIONS)
def test_converting_a_quaternion_to_a_matrix_and_back_gives_the_same_rotation(q: np.ndarray) -> None:
    found = quaternions_of(matrix_of_quaternions(q))
    assert abs(float(found @ q)) == pytest.approx(1.0, abs=1e-14)
    assert found[3] >= 0.0


@pytest.mark.parametrize("order", ORDERS)
def test_angles_turn_about_fixed_axes_in_the_order_of_their_names(order: str) -> None:
    # A quarter turn about z carries x to y, one about x carries y to z, one about y carries z to x.
    angles, vector = np.array([90.0, 90.0, 90.0]), np.array([1.0, 2.0, 3.0])
    quarter = {
        "X": lambda v: [v[0], -v[2], v[1]],
        "Y": lambda v: [v[2], v[1], -v[0]],
        "Z": lambda v: [-v[1], v[0], v[2]],
    }
    expected = vector
    for axis in order:
        expected = np.array(quarter[axis](expected))
    np.testing.assert_allclose(vector @ matrix_of_angles(angles, order), expected, atol=1e-14)


@given(ANGLES, st.sampled_from(ORDERS))
def test_converting_angles_to_a_matrix_and_back_gives_the_same_rotation(angles: np.ndarray, order: str) -> None:
    turned = matrix_of_angles(angles, order)
    np.testing.assert_allclose(matrix_of_angles(angles_of(turned, order), order), turned, atol=1e-7)


@pytest.mark.parametrize(("order", "middle"), list(itertools.product(ORDERS, (90.0, -90.0))))
def test_in_gimbal_lock_the_last_angle_is_zero(order: str, middle: float) -> None:
    angles = np.zeros(3)
    for axis, angle in zip(order, (20.0, middle, 30.0), strict=True):
        angles["XYZ".index(axis)] = angle
    turned = matrix_of_angles(angles, order)
    found = angles_of(turned, order)
    assert found["XYZ".index(order[2])] == 0.0
    np.testing.assert_allclose(matrix_of_angles(found, order), turned, atol=1e-7)


@given(QUATERNIONS, st.floats(-360.0, 360.0))
def test_a_rotation_about_an_axis_keeps_the_axis_and_turns_by_the_angle(q: np.ndarray, angle: float) -> None:
    axis = q[:3] if np.linalg.norm(q[:3]) > 0.1 else np.array([0.0, 0.0, 2.0])
    turn = matrix_about(axis, np.array(angle))
    np.testing.assert_allclose(axis @ turn, axis, atol=1e-13)
    assert np.trace(turn) == pytest.approx(1.0 + 2.0 * math.cos(math.radians(angle)), abs=1e-12)


def test_without_scale_removes_scale_and_mirroring() -> None:
    turn = matrix_of_quaternions(np.array([0.0, 0.0, HALF, HALF]))
    for scale in ([1.0, 2.0, 3.0], [-1.0, -1.0, -1.0]):
        np.testing.assert_allclose(without_scale(np.array(scale)[:, None] * turn), turn, atol=1e-15)


def test_arrays_are_converted_like_single_values() -> None:
    quaternions = np.random.default_rng(3).normal(size=(5, 4))
    matrices = rotation_matrix(quaternions)
    for one, turned in zip(quaternions, matrices, strict=True):
        np.testing.assert_allclose(rotation_matrix(one), turned, atol=1e-15)
    np.testing.assert_allclose(rotation_matrix(matrices.reshape(5, 9)), matrices, atol=1e-14)
    np.testing.assert_allclose(matrix_of_quaternions(quaternions_of(matrices)), matrices, atol=1e-14)
    np.testing.assert_allclose(rotation_matrix(angles_of(matrices, "XYZ")), matrices, atol=1e-13)


@given(QUATERNIONS, QUATERNIONS, st.floats(0.0, 1.0))
def test_slerp_turns_at_a_steady_rate_along_the_shorter_arc(a: np.ndarray, b: np.ndarray, alpha: float) -> None:
    between, whole = slerp(a, b, np.array(alpha)), math.acos(min(1.0, abs(float(a @ b))))
    assert np.linalg.norm(between) == pytest.approx(1.0, abs=1e-14)
    assert math.acos(min(1.0, abs(float(a @ between)))) == pytest.approx(alpha * whole, abs=1e-7)
