"""HolonomicRobotUsdSetup: the geometry of a robot's wheels in the frame of a centre."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.holonomic_wheels import HolonomicWheel
from graphengine.devices.rotation import Vector3, rotate
from graphengine.format.errors import ContextError, PrimError
from graphengine.nodes.wheeled_robots.usd_setup import HolonomicRobotUsdSetup
from graphengine.testing import RecordingContext
from tests.nodes.harness import computed, ready, yaw

LEFT: Vector3 = (0.0, 1.0, 0.0)


def wheel(number: int = 0, axle: Vector3 = LEFT) -> HolonomicWheel:
    return HolonomicWheel(f"wheel_{number}", 0.05 + number, (0.2, 0.1 * number, -0.03), axle, 45.0 - 90.0 * number)


def read(*wheels: HolonomicWheel, **inputs: Any) -> HolonomicRobotUsdSetup:
    """The node on a robot with these wheels at (3, 4), turned to the left, which has a centre 0.1 m ahead of its base link."""
    context = RecordingContext()
    context.world.add_robot("/bot", ["wheel_0", "wheel_1"], holonomic_wheels=wheels)
    context.world.stage.add("/bot/Geometry/base_link/com", "frame", position=(0.1, 0.0, 0.0), orientation=yaw(math.pi))
    context.world.body(context.world.stage.find("/bot")).place((3.0, 4.0, 0.0), yaw(math.pi / 2))
    return computed(HolonomicRobotUsdSetup, context, **inputs)


@pytest.mark.parametrize(
    "inputs", [{"robot_prim": "/bot"}, {"use_path": True, "robot_prim_path": "/bot", "robot_prim": "/nothing"}]
)
def test_wheels_are_in_the_frame_of_the_base_link_wherever_the_robot_stands(inputs: dict[str, Any]) -> None:
    node = read(wheel(0), wheel(1), **inputs)
    assert node.wheel_dof_names == ("wheel_0", "wheel_1")
    assert node.wheel_radius.tolist() == [0.05, 1.05]
    assert node.mecanum_angles.tolist() == [45.0, -45.0]
    np.testing.assert_allclose(node.wheel_positions, [(0.2, 0.0, -0.03), (0.2, 0.1, -0.03)], atol=1e-12)
    np.testing.assert_allclose(node.wheel_orientations, [(1, 0, 0, 0)] * 2, atol=1e-12)
    assert (node.wheel_axis, node.up_axis) == (LEFT, (0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    "inputs",
    [
        {"robot_prim": "/bot", "com_prim": "/bot/base_link/com"},
        {"use_path": True, "robot_prim_path": "/bot", "com_prim_path": "/bot/base_link/com"},
    ],
)
def test_wheels_are_in_the_frame_of_the_given_centre(inputs: dict[str, Any]) -> None:
    node = read(wheel(), **inputs)
    np.testing.assert_allclose(node.wheel_positions, [(-0.1, 0.0, -0.03)], atol=1e-12)
    np.testing.assert_allclose(np.abs(node.wheel_orientations), [(0, 0, 0, 1)], atol=1e-12)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda axle: math.hypot(*axle) > 0.1))
def test_the_orientation_of_a_wheel_turns_the_wheel_axis_to_its_axle(axle: Vector3) -> None:
    x, y, z = (part / math.hypot(*axle) for part in axle)
    node = read(wheel(axle=(x, y, z)), robot_prim="/bot")
    w, i, j, k = node.wheel_orientations[0].tolist()
    assert math.hypot(w, i, j, k) == pytest.approx(1.0)
    np.testing.assert_allclose(rotate((i, j, k, w), node.wheel_axis), (x, y, z), atol=1e-7)


def test_an_axle_to_the_right_is_a_left_axle_turned_by_half_a_turn_about_z() -> None:
    node = read(wheel(axle=(0.0, -1.0, 0.0)), robot_prim="/bot")
    np.testing.assert_allclose(np.abs(node.wheel_orientations), [(0, 0, 0, 1)], atol=1e-9)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "robotPrim is empty"),
        ({"use_path": True, "robot_prim": "/bot"}, "robotPrimPath is empty"),
        ({"robot_prim": "/bot"}, "no wheel of /bot has rollers"),
    ],
)
def test_a_missing_robot_and_wheels_without_rollers_are_errors(inputs: dict[str, Any], message: str) -> None:
    with pytest.raises(ContextError, match=message):
        read(**inputs)


def test_a_prim_that_does_not_identify_a_robot_is_refused() -> None:
    context = RecordingContext()
    context.world.add_body("/box")
    with pytest.raises(PrimError, match="is not the root prim, base link or articulation root of a robot"):
        ready(HolonomicRobotUsdSetup, context, robot_prim="/box")
