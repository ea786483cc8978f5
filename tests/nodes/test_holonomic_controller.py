"""HolonomicController."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.nodes.wheeled_robots.holonomic import HolonomicController
from graphengine.testing import RecordingContext
from tests.nodes.harness import fed, matrix

Floats = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
speeds = st.floats(-3.0, 3.0)
twists = st.tuples(speeds, speeds, speeds)
NONE = (0.0, 0.0, 0.0)


class Base:
    """Wheels at (x, y) whose axles point in a direction, with rollers at an angle, both in degrees; radii in m."""

    def __init__(self, *wheels: tuple[float, float, float, float, float]) -> None:
        x, y, heading, angle, radius = np.array(wheels).T
        self.positions = np.column_stack([x, y, np.full(len(x), -0.05)])
        half = np.radians(heading) / 2
        self.orientations = np.column_stack([np.cos(half), 0 * x, 0 * x, np.sin(half)])
        self.angles, self.radii = angle, radius
        self.axles = np.column_stack([np.cos(2 * half), np.sin(2 * half), 0 * x])
        turned = 2 * half + np.radians(angle)
        self.rollers = np.column_stack([np.cos(turned), np.sin(turned), 0 * x])

    def controller(self, twist: tuple[float, float, float] = NONE, **inputs: Any) -> HolonomicController:
        return HolonomicController(
            wheel_radius=self.radii,
            wheel_positions=self.positions,
            wheel_orientations=self.orientations,
            mecanum_angles=self.angles,
            input_velocity=twist,
            **inputs,
        )

    def contributions(self) -> Floats:
        """What each wheel adds to vx, vy and wz when it turns at 1 rad/s, shape (3, wheels)."""
        pushes = self.radii[:, None] * self.rollers
        return np.vstack([pushes[:, :2].T, np.cross(pushes, self.positions * [1, 1, 0])[:, 2]])


OMNI = Base((0.1, 0, 0, 90, 0.04), (-0.05, 0.09, 120, 90, 0.05), (-0.05, -0.09, -120, 90, 0.04))
MECANUM = Base(
    (0.2, 0.15, 90, 45, 0.05), (0.2, -0.15, 90, -45, 0.05), (-0.2, 0.15, 90, -45, 0.05), (-0.2, -0.15, 90, 45, 0.05)
)
bases = pytest.mark.parametrize("base", [OMNI, MECANUM], ids=["omni", "mecanum"])


def wheels(node: HolonomicController) -> Floats:
    """The command of one more compute."""
    node.compute()
    return node.joint_velocity_command


@bases
@given(twist=twists)
def test_contributions_of_the_wheels_add_up_to_the_twist(base: Base, twist: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(base.contributions() @ wheels(base.controller(twist)), twist, atol=1e-9)


@given(twist=twists, share=st.floats(-2.0, 2.0))
def test_no_other_wheel_speeds_for_the_twist_have_a_smaller_weighted_sum_of_squares(
    twist: tuple[float, float, float], share: float
) -> None:
    command = wheels(MECANUM.controller(twist))
    without_effect = np.linalg.svd(MECANUM.contributions())[2][3]
    np.testing.assert_allclose(MECANUM.contributions() @ without_effect, 0.0, atol=1e-12)
    other = command + share * without_effect
    assert MECANUM.radii @ command**2 <= MECANUM.radii @ other**2 + 1e-9


@bases
@given(twist=twists)
def test_rolling_wheels_do_not_slip_along_their_rollers_axis(base: Base, twist: tuple[float, float, float]) -> None:
    # A wheel's lowest point moves with the hub, v + w x p, and with the turn about the axle, x a x (0, 0, -r).
    command = wheels(base.controller(twist, rolling=True))
    hubs = np.array([twist[0], twist[1], 0.0]) + np.cross(twist[2] * UP, base.positions)
    touching = hubs - (command * base.radii)[:, None] * np.cross(base.axles, UP)
    np.testing.assert_allclose(np.sum(touching * base.rollers, axis=1), 0.0, atol=1e-9)


def test_rolling_mecanum_wheels_turn_equally_for_forward_and_crosswise_for_sideways_motion() -> None:
    ahead = wheels(MECANUM.controller((1.0, 0.0, 0.0), rolling=True))
    sideways = wheels(MECANUM.controller((0.0, 1.0, 0.0), rolling=True))
    turning = wheels(MECANUM.controller((0.0, 0.0, 1.0), rolling=True))
    np.testing.assert_allclose(ahead, np.full(4, 20.0))
    np.testing.assert_allclose(sideways, [-20.0, 20.0, 20.0, -20.0])
    np.testing.assert_allclose(turning, [-7.0, 7.0, -7.0, 7.0])  # (0.2 + 0.15) / 0.05


def test_without_a_twist_the_wheel_speeds_are_0() -> None:
    assert wheels(MECANUM.controller()).tolist() == [0.0, 0.0, 0.0, 0.0]


def test_gains_apply_before_limits_and_limits_keep_the_direction() -> None:
    node = MECANUM.controller((0.3, 0.4, -2.0), linear_gain=4.0, angular_gain=0.5)
    np.testing.assert_allclose(MECANUM.contributions() @ wheels(node), [1.2, 1.6, -1.0], atol=1e-9)
    node.max_linear_speed, node.max_angular_speed = 1.0, 0.25
    np.testing.assert_allclose(MECANUM.contributions() @ wheels(node), [0.6, 0.8, -0.25], atol=1e-9)


def test_if_one_wheel_exceeds_its_limit_all_wheels_are_scaled_down() -> None:
    free = wheels(MECANUM.controller((1.0, 0.5, 2.0)))
    held = wheels(MECANUM.controller((1.0, 0.5, 2.0), max_wheel_speed=3.0))
    assert np.abs(held).max() == pytest.approx(3.0)
    np.testing.assert_allclose(held / free, 3.0 / np.abs(free).max())


def test_a_limit_of_0_means_no_limit() -> None:
    limits = {"max_linear_speed": 0.0, "max_angular_speed": 0.0, "max_wheel_speed": 0.0}
    fast, slow = MECANUM.controller((1e7, 0.0, 1e7), **limits), MECANUM.controller((1.0, 0.0, 1.0))
    np.testing.assert_allclose(wheels(fast), 1e7 * wheels(slow))


def test_one_radius_and_one_angle_apply_to_all_wheels() -> None:
    node = OMNI.controller((1.0, 2.0, 3.0))
    node.wheel_radius, node.mecanum_angles = np.array([0.04]), np.array([90.0])
    same = OMNI.controller((1.0, 2.0, 3.0))
    same.wheel_radius = np.full(3, 0.04)
    np.testing.assert_array_equal(wheels(node), wheels(same))


def test_orientations_and_axes_need_not_have_length_1() -> None:
    node = MECANUM.controller((1.0, 2.0, 3.0), wheel_axis=(3.0, 0.0, 0.0), up_axis=(0.0, 0.0, 2.0))
    node.wheel_orientations = 5.0 * MECANUM.orientations
    np.testing.assert_allclose(wheels(node), wheels(MECANUM.controller((1.0, 2.0, 3.0))))


def test_geometry_takes_effect_when_it_is_set() -> None:
    node = OMNI.controller((1.0, 2.0, 3.0))
    before = wheels(node)
    for field, value in (("wheel_radius", np.array([0.08])), ("up_axis", (0.0, 0.0, -1.0)), ("rolling", True)):
        setattr(node, field, value)
        after = wheels(node)
        assert not np.allclose(after, before)
        before = after


def test_after_a_stop_there_is_no_command_until_the_next_compute() -> None:
    node = OMNI.controller((1.0, 0.0, 0.0))
    before = wheels(node)
    RecordingContext().stop(node)
    assert node.joint_velocity_command.tolist() == []
    np.testing.assert_array_equal(wheels(node), before)


@pytest.mark.parametrize(
    ("inputs", "complaint"),
    [
        (
            {"wheel_radius": [0.1, 0.1]},
            r"wheelRadius, wheelPositions must be of equal length, or wheelRadius of length 1 for all wheels, it is \[2, 3\]",
        ),
        ({"wheel_radius": [0.1, 0.0, 0.1]}, "wheelRadius must be above 0"),
        ({"mecanum_angles": []}, r"mecanumAngles, .* must be of equal length, or mecanumAngles of length 1.*\[0, 3\]"),
        (
            {"wheel_orientations": [[1.0, 0.0, 0.0, 0.0]]},
            r"wheelOrientations, .* must be of equal length, one orientation for each position.*\[1, 3\]",
        ),
        ({"wheel_orientations": [[0.0] * 4] * 3}, "wheelOrientations must be of a finite length above 0"),
        (
            {"wheel_positions": [[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]]},
            "wheelPositions must be the positions of 3 or more wheels",
        ),
        (
            {"wheel_orientations": [[1.0, 0.0, 0.0, 0.0]] * 3},
            "the geometry of wheels that together drive the base in every direction",
        ),
        (
            {"mecanum_angles": [0.0, 90.0, 60.0], "rolling": True},
            "must be such that no roller axis is parallel to the axle",
        ),
        ({"up_axis": NONE}, "upAxis must be of a finite length above 0"),
        (
            {"wheel_positions": [[math.nan, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]},
            "wheelPositions must be finite",
        ),
        ({"wheel_radius": [0.1, math.inf, 0.1]}, "wheelRadius must be finite"),
        ({"mecanum_angles": [math.inf] * 3}, "mecanumAngles must be finite"),
        ({"wheel_orientations": [[math.nan] * 4] * 3}, "wheelOrientations must be finite"),
        ({"wheel_axis": (math.inf, 0.0, 0.0)}, "wheelAxis must be finite"),
        ({"up_axis": (0.0, 0.0, math.nan)}, "upAxis must be finite"),
    ],
)
def test_an_impossible_geometry_is_refused(inputs: dict[str, Any], complaint: str) -> None:
    node = OMNI.controller((1.0, 0.0, 0.0))
    changed = fed(HolonomicController, **{**{name: getattr(node, name) for name in ARRAYS}, **inputs})
    with pytest.raises(ValueError, match=complaint):
        changed.compute()


ARRAYS = ("wheel_radius", "wheel_positions", "wheel_orientations", "mecanum_angles")


def test_orientations_are_w_x_y_z() -> None:
    # A quarter turn about z takes the axle from x to y: with w first its quaternion is (0.707, 0, 0, 0.707).
    quarter = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    np.testing.assert_allclose(matrix(quarter) @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(MECANUM.orientations[0], [quarter[3], *quarter[:3]])
