"""Splines of joints: laws of interpolation for points with positions, velocities and accelerations."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.ros2.joint_spline import Floats, JointPoint, JointSpline

NUMBERS = st.floats(-10.0, 10.0, allow_subnormal=False)
DEGREES = st.sampled_from((1, 3, 5))


@st.composite
def splines(draw: st.DrawFn) -> JointSpline:
    """Two joints that pass two to six points; each point has velocities and accelerations, velocities, or neither."""
    durations = draw(st.lists(st.floats(0.05, 3.0), min_size=1, max_size=5))
    times = list(itertools.accumulate([draw(st.floats(0.0, 100.0)), *durations]))
    points = []
    for time in times:
        states = [np.array([draw(NUMBERS), draw(NUMBERS)]) for _ in range(3)]
        degree = draw(DEGREES)
        points.append(JointPoint(time, states[0], *states[1 : (degree + 1) // 2]))
    return JointSpline(tuple(points))


def polynomial(coefficients: Sequence[float], time: float, derivative: int = 0) -> Floats:
    """A polynomial of one joint, lowest power first."""
    return np.array([np.polynomial.Polynomial(coefficients).deriv(derivative)(time)])


@given(splines())
def test_a_spline_passes_its_points(spline: JointSpline) -> None:
    for point in spline.points:
        np.testing.assert_allclose(spline.sample(point.time)[0], point.positions, atol=1e-9)


@given(splines())
def test_a_spline_is_continuous(spline: JointSpline) -> None:
    for point in spline.points:
        before, after = (spline.sample(point.time + step)[0] for step in (-1e-9, 1e-9))
        np.testing.assert_allclose(before, after, atol=1e-5)


@given(splines())
def test_velocities_at_points_are_those_of_the_trajectory_if_both_ends_of_a_segment_have_them(
    spline: JointSpline,
) -> None:
    for before, after in itertools.pairwise(spline.points):
        if before.velocities is None or after.velocities is None:
            continue
        np.testing.assert_allclose(spline.sample(before.time)[1], before.velocities, atol=1e-6)
        np.testing.assert_allclose(spline.sample(after.time - 1e-9)[1], after.velocities, atol=1e-4)


@given(splines(), st.lists(st.floats(0.0, 120.0), min_size=1, max_size=8))
def test_a_sample_does_not_depend_on_earlier_samples(spline: JointSpline, times: list[float]) -> None:
    def sampled(points: Sequence[JointPoint]) -> list[list[float]]:
        copy = JointSpline(tuple(map(dataclasses.replace, points)))
        return [array.tolist() for time in times for array in copy.sample(time)]

    assert sampled(spline.points) == [array.tolist() for time in times for array in spline.sample(time)]


@given(splines(), st.floats(0.01, 0.99))
def test_velocities_are_the_slope_of_positions(spline: JointSpline, share: float) -> None:
    for before, after in itertools.pairwise(spline.points):
        time, step = before.time + share * (after.time - before.time), 1e-5 * (after.time - before.time)
        (early, _), (late, _), (_, velocity) = (spline.sample(time + shift) for shift in (-step, step, 0.0))
        np.testing.assert_allclose((late - early) / (2 * step), velocity, rtol=1e-4, atol=1e-3)


@given(DEGREES, st.lists(NUMBERS, min_size=6, max_size=6), st.floats(0.1, 2.0), st.floats(0.0, 1.0))
def test_a_polynomial_motion_of_the_splines_degree_is_reproduced(
    degree: int, coefficients: list[float], duration: float, share: float
) -> None:
    motion = coefficients[: degree + 1]
    orders = range((degree + 1) // 2)
    points = [JointPoint(time, *(polynomial(motion, time, order) for order in orders)) for time in (0.0, duration)]
    position, velocity = JointSpline(tuple(points)).sample(share * duration)
    scale = 1.0 + max(map(abs, motion)) * 2.0**degree
    assert position == pytest.approx(polynomial(motion, share * duration), abs=1e-9 * scale)
    if share < 1.0:
        assert velocity == pytest.approx(polynomial(motion, share * duration, 1), abs=1e-7 * scale)


@given(splines(), st.floats(1e-6, 100.0))
def test_joints_rest_before_and_after_a_spline(spline: JointSpline, away: float) -> None:
    for time, point in ((spline.points[0].time - away, spline.points[0]), (spline.end + away, spline.points[-1])):
        positions, velocities = spline.sample(time)
        assert positions.tolist() == point.positions.tolist()
        assert not velocities.any()
