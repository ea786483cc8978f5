"""The limits that the benchmark of bases reads from a robot's graphs, by which it judges the robot's speeds."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.bringup.calibration.figures import Twist
from tests.bench.base_figures import Base, outside
from tests.bringup.robots.imported_bases import CAR, DIFFERENTIAL, description, imported, scene, slow
from tests.physics.bases import MECANUM


def base_of(folder: Path, text: str) -> Base:
    """The base of an imported description."""
    loaded = ge.load(scene(folder, imported(folder, text)))
    with loaded.session(domain=0) as sim:
        return Base(sim, loaded, "bot")


def test_a_mecanum_base_is_limited_by_the_sum_of_track_and_wheelbase(tmp_path: Path) -> None:
    """Its wheels turn at 10 rad/s at most; the arm of a turn is (0.3 + 0.4208) / 2 m."""
    base = base_of(tmp_path, slow(description(MECANUM), 10.0))
    rim, lever = 10.0 * MECANUM.radius, (0.3 + 0.4208) / 2
    assert (base.limits.rim, base.limits.lever) == pytest.approx((rim, lever))
    assert base.limits.deceleration == pytest.approx(1.0, rel=0.01)  # of the drives' ramps, m/s2
    scaled = base.limits.scaled(Twist(x=0.4, yaw=1.0))
    assert (scaled.x, scaled.yaw) == pytest.approx(tuple(rim / (0.4 + lever) * each for each in (0.4, 1.0)))
    assert not base.car


def test_a_car_that_takes_twists_does_not_turn_on_the_spot(tmp_path: Path) -> None:
    base = base_of(tmp_path, description(CAR))
    assert base.car
    assert base.steering == math.inf
    assert base.wheel_base == pytest.approx(0.4)


def test_a_differential_base_is_limited_by_half_its_track(tmp_path: Path) -> None:
    base = base_of(tmp_path, slow(description(DIFFERENTIAL), 8.0))
    assert (base.limits.rim, base.limits.lever) == pytest.approx((0.4, 0.15))
    assert not base.car


@pytest.mark.parametrize(
    ("name", "value", "skid", "bad"),
    [
        ("straight", [1.049, 0.951], False, False),
        ("straight", [1.0, 0.949], False, True),
        ("straight", [1.06, 1.0], True, True),
        ("arc_1.0", [1.06, 1.0], False, True),
        ("arc_1.0", [1.06, 1.0], True, False),
        ("arc_1.0", [1.0, 0.94], True, True),
        ("arc_1.0_turn", [1.09, 0.91], True, False),
        ("arc_1.0_turn", [1.09, 0.91], False, True),
        ("slope_spot", math.nan, True, True),
        ("stop", 1.19, False, False),
        ("stop", 1.21, False, True),
    ],
)
def test_figures_are_judged_by_their_bounds(name: str, value: float | list[float], skid: bool, bad: bool) -> None:
    assert outside({name: value}, skid=skid) == ([name] if bad else [])
