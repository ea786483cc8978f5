"""Computes the noise parameters of nav2_amcl's motion models, alpha1 to alpha5, for a calibrated robot."""

from __future__ import annotations

from dataclasses import astuple

from graphengine.bringup.calibration.figures import Alphas, Calibration

LEAST = (0.01, 0.01, 0.01, 0.01, 0.01)
"""Smallest values of alpha1 to alpha5; the standard deviation is then 10 % of the motion, such as 0.025 m for 0.25 m.

Without motion noise, resampling soon makes all particles copies of each other. If the filter then loses the true pose, no
particle is near this pose: particle deprivation (Thrun, Burgard, Fox: Probabilistic Robotics, 4.3.4). A filter with the small
alphas of exact odometry therefore fails where a filter with larger alphas recovers. The particles also have to cover errors
due to the cell size of the map, and slip on floors that are less flat than the floor of the calibration.
"""


def amcl_alphas(result: Calibration) -> tuple[float, float, float, float, float]:
    """Return alpha1 to alpha5 of nav2_amcl: the measured values, but at least the values in `LEAST`.

    DifferentialMotionModel splits a motion into a rotation a1, a translation d and a rotation a2. A rotation a has the variance
    alpha1 a^2 + alpha2 d^2; the translation has alpha3 d^2 + alpha4 (a1^2 + a2^2). OmniMotionModel has alpha1 a^2 + alpha2 d^2
    for the rotation, alpha3 d^2 + alpha4 a^2 along the translation and alpha4 a^2 + alpha5 d^2 across. In both models,
    alphas are factors of squares and are not squared themselves: 0.01 is an error of 10 %. Each measured alpha is the
    mean square of the ratio error / motion over steps of 0.25 m or 0.2 rad, at which AMCL updates by default. If the robot
    has several odometry topics, each alpha is the largest value among the topics. An alpha without a measurement has the value in
    `LEAST`.
    """
    measured = [astuple(one.alphas) for one in result.odometry] or [astuple(Alphas())]
    first, second, third, fourth, fifth = (
        max([least, *(value for value in values if value is not None)])
        for least, values in zip(LEAST, zip(*measured, strict=True), strict=True)
    )
    return first, second, third, fourth, fifth
