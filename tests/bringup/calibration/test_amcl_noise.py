"""The parameters of AMCL that follow from a calibration."""

from __future__ import annotations

from dataclasses import replace

import pytest

from graphengine.bringup.calibration.amcl_noise import LEAST, amcl_alphas
from graphengine.bringup.calibration.figures import Alphas, Calibration, Odometry

MEASURED = Calibration("dingo", "/cmd_vel", "geometry_msgs/msg/Twist", 0.3, 0.6, True)


def calibrated(*alphas: Alphas) -> Calibration:
    return replace(
        MEASURED, odometry=tuple(Odometry(f"/odom{n}", "base_link", alphas=one) for n, one in enumerate(alphas))
    )


def test_measured_noise_is_used() -> None:
    assert amcl_alphas(calibrated(Alphas(0.02, 0.03, 0.04, 0.05, 0.06))) == (0.02, 0.03, 0.04, 0.05, 0.06)


def test_an_exact_odometry_and_an_unknown_one_get_the_least_noise() -> None:
    assert amcl_alphas(calibrated(Alphas(0.0, 1e-9, 0.02, 0.0))) == (*LEAST[:2], 0.02, *LEAST[3:])
    assert amcl_alphas(MEASURED) == LEAST
    assert min(LEAST) > 0.0


@pytest.mark.parametrize("order", [1, -1])
def test_of_several_odometry_topics_the_largest_error_counts(order: int) -> None:
    both = (Alphas(0.02, 0.03, 0.02, None), Alphas(0.03, 0.02, None, 0.5))[::order]
    assert amcl_alphas(calibrated(*both)) == (0.03, 0.03, 0.02, 0.5, LEAST[4])
