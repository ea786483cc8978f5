"""Figures of motions that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.bringup.calibration import measuring
from graphengine.bringup.calibration.drive_recorder import Trace
from graphengine.bringup.calibration.figures import Floats, Motion, Twist
from graphengine.bringup.calibration.odometry_errors import OdometryMeter

DT = 0.01
TOPIC = "/odom"
NOTHING: Floats = np.zeros((0, 0))


def path(twist: Twist, seconds: float, pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Floats:
    """The path of a base that begins at a pose and keeps a velocity."""
    ideal, yaw = measuring.ideal_path([(twist, seconds)], DT), pose[2]
    cosine, sine = math.cos(yaw), math.sin(yaw)
    turned = np.column_stack(
        (cosine * ideal[:, 0] - sine * ideal[:, 1], sine * ideal[:, 0] + cosine * ideal[:, 1], ideal[:, 2])
    )
    return np.asarray(turned + pose)


def trace(base: Floats, odometry: Floats) -> Trace:
    return Trace(DT, base, np.zeros((len(base), 0)), {TOPIC: odometry}, {TOPIC: base})


speeds = st.floats(-1.0, 1.0)


@given(speeds, speeds, speeds, st.tuples(speeds, speeds, st.floats(-3.0, 3.0)))
def test_the_mean_velocity_of_a_constant_motion_is_its_velocity(
    x: float, y: float, yaw: float, pose: tuple[float, float, float]
) -> None:
    base = path(Twist(x, y, yaw), 2.0, pose)
    reached = measuring.mean_velocity(trace(base, base))
    assert (reached.x, reached.y, reached.yaw) == pytest.approx((x, y, yaw), abs=1e-9)


@given(speeds, speeds, speeds, st.tuples(speeds, speeds, st.floats(-3.0, 3.0)))
def test_a_displacement_does_not_depend_on_where_the_motion_begins(
    x: float, y: float, yaw: float, pose: tuple[float, float, float]
) -> None:
    twist = Twist(x, y, yaw)
    assert measuring.displacement(path(twist, 1.0, pose)) == pytest.approx(
        measuring.displacement(path(twist, 1.0)), abs=1e-9
    )
    assert measuring.in_first_frame(path(twist, 1.0, pose))[-1] == pytest.approx(path(twist, 1.0)[-1], abs=1e-9)


def test_the_settle_time_of_a_ramp_is_when_it_enters_the_band() -> None:
    speed = np.minimum(
        np.arange(1, 401) * DT, 1.0
    )  # 1 m/s2 to 1 m/s: 95 % after 0.95 s, and half of the smoothing later
    base = np.column_stack((np.r_[0.0, np.cumsum(speed * DT)], np.zeros(401), np.zeros(401)))
    assert measuring.settle_time(trace(base, base), 0, 1.0) == pytest.approx(1.0, abs=0.02)


def test_a_velocity_that_keeps_changing_does_not_settle() -> None:
    speed = 1.0 + 0.2 * np.sin(np.arange(400) * DT * 2.0)
    base = np.column_stack((np.r_[0.0, np.cumsum(speed * DT)], np.zeros(401), np.zeros(401)))
    assert measuring.settle_time(trace(base, base), 0, 1.0) is None
    assert not measuring.is_steady(trace(base, base), Twist(x=1.0))


def test_all_commanded_components_are_to_be_steady() -> None:
    ramp = np.minimum(np.arange(1, 401) * DT / 2.0, 1.0)
    base = np.column_stack((np.r_[0.0, np.cumsum(ramp * DT)], np.zeros(401), 0.0 * np.arange(401)))
    assert not measuring.is_steady(trace(base, base).part(100), Twist(x=1.0, yaw=1.0))
    assert measuring.is_steady(trace(base, base).part(100), Twist(yaw=1.0))
    assert measuring.is_steady(trace(base, base).part(250), Twist(x=1.0, yaw=1.0))


def test_a_turn_about_another_point_comes_back_after_one_turn() -> None:
    base = measuring.at_offset(path(Twist(yaw=0.7), 12.0), (0.3, -0.1))
    moved = measuring.one_turn(base)
    assert moved is not None
    assert moved == pytest.approx([0.0, 0.0], abs=1e-4)  # the path is a polygon
    assert measuring.one_turn(path(Twist(yaw=0.7), 8.0)) is None


@given(st.floats(0.9, 1.1), st.sampled_from([1.0, -1.0]))
def test_the_distance_error_of_odometry_equals_the_error_of_its_wheel_radius(scale: float, sign: float) -> None:
    base = path(Twist(x=0.3 * sign), 4.0)
    meter = OdometryMeter(TOPIC)
    meter.take(Motion("forward", "straight", Twist(x=0.3), Twist(x=0.3), 1.0), trace(base, base * (scale, 1.0, 1.0)))
    figures = meter.figures("base_link", omni=False)
    assert figures.distance_error == pytest.approx(scale - 1.0, abs=1e-9)
    assert figures.alphas.alpha3 == pytest.approx((scale - 1.0) ** 2, abs=1e-9)  # nav2: alpha3 d^2 is the variance
    assert figures.alphas.alpha1 is None
    assert figures.alphas.alpha5 is None


@given(st.floats(0.9, 1.1), st.sampled_from([1.0, -1.0]))
def test_the_turn_error_of_odometry_equals_the_error_of_its_track(scale: float, sign: float) -> None:
    base = path(Twist(yaw=0.6 * sign), 11.0)
    meter = OdometryMeter(TOPIC)
    meter.take(Motion("turn_left", "turn", Twist(yaw=0.6), Twist(yaw=0.6), 1.0), trace(base, base * (1.0, 1.0, scale)))
    figures = meter.figures("base_link", omni=False)
    assert figures.turn_error == pytest.approx(math.tau * (scale - 1.0), abs=1e-9)
    assert figures.alphas.alpha1 == pytest.approx((scale - 1.0) ** 2, abs=1e-9)
    assert figures.covariances.heading_variance_by_turn == pytest.approx(
        (scale - 1.0) ** 2 * 0.204, rel=0.01
    )  # 34 rows


def test_noise_that_grows_with_the_way_has_the_variance_per_metre_that_it_was_made_with() -> None:
    random = np.random.default_rng(7)
    meter = OdometryMeter(TOPIC)
    variance = 4e-4  # m2/m
    for _ in range(40):
        base = path(Twist(x=0.5), 10.0)
        steps = random.normal(0.0, math.sqrt(variance * 0.005), len(base) - 1)
        odometry = base + np.column_stack((np.r_[0.0, np.cumsum(steps)], np.zeros(len(base)), np.zeros(len(base))))
        meter.take(Motion("forward", "straight", Twist(x=0.5), Twist(x=0.5), 1.0), trace(base, odometry))
    assert meter.figures("base_link", omni=False).covariances.distance_variance == pytest.approx(variance, rel=0.1)


def test_an_unpublished_odometry_is_reported() -> None:
    base = path(Twist(x=0.3), 4.0)
    meter = OdometryMeter(TOPIC)
    meter.take(
        Motion("forward", "straight", Twist(x=0.3), Twist(x=0.3), 1.0), trace(base, np.full_like(base, math.nan))
    )
    assert meter.notes == ["/odom: not published during the test drives"]
    assert meter.figures("", omni=False).distance_error is None


def test_the_ideal_square_ends_where_it_began() -> None:
    side, corner = (Twist(x=0.5), 2.0), (Twist(yaw=math.pi / 2.0), 1.0)
    assert measuring.ideal_path([side, corner] * 4, DT)[-1] == pytest.approx([0.0, 0.0, math.tau], abs=1e-9)
