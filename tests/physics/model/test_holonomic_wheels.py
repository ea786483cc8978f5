"""The mecanum and omnidirectional wheels of a robot, by the friction of their materials."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.holonomic_wheels import HolonomicWheel
from tests.physics.bases import FOUR, MECANUM, MECANUM_WHEELS, ON_THE_FLOOR, SKID, SKID_WHEELS, Base, Wheel, material
from tests.physics.harness import Project


def wheels_of(project: Project, base: Base, keys: str) -> tuple[HolonomicWheel, ...]:
    """The wheels of a base with some materials."""
    base.write(project, keys).write("scene.yaml", ON_THE_FLOOR.format(height=base.radius))
    found: tuple[HolonomicWheel, ...] = project.load().stage.find("/bot").facts["holonomic_wheels"]
    return found


def test_the_wheels_of_a_mecanum_base_have_their_radius_place_axle_and_roller(project: Project) -> None:
    found = wheels_of(project, MECANUM, MECANUM_WHEELS)
    assert [wheel.joint for wheel in found] == [f"{name}_joint" for name in FOUR]
    assert {wheel.radius for wheel in found} == {0.05}
    assert [wheel.position for wheel in found] == [(wheel.x, wheel.y, 0.0) for wheel in MECANUM.wheels]
    assert [wheel.axle for wheel in found] == [(0.0, 1.0, 0.0)] * 4
    assert [wheel.roller_angle for wheel in found] == pytest.approx([45.0, -45.0, -45.0, 45.0])


@pytest.mark.parametrize("direction", [(1, -1, 0), (-1, 1, 0), (2, -2, 5)])
def test_the_axis_of_a_roller_has_no_sign_and_lies_on_the_floor(
    project: Project, direction: tuple[int, int, int]
) -> None:
    (wheel,) = wheels_of(project, MECANUM, "materials:\n" + material(FOUR[:1], direction, 0.0))
    assert wheel.roller_angle == pytest.approx(45.0)


def test_the_greater_friction_is_along_the_roller_even_if_it_is_written_across(project: Project) -> None:
    keys = "materials:\n  M: {dynamic_friction: 0.0, across: 0.8, direction: [1, 1, 0], bind: [front_left]}\n"
    (wheel,) = wheels_of(project, MECANUM, keys)
    assert wheel.roller_angle == pytest.approx(45.0)


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0, math.pi])
def test_the_angle_is_from_the_axle_wherever_that_points(project: Project, heading: float) -> None:
    base = Base("one", (Wheel("wheel", 0.1, 0.0, heading), Wheel("other", -0.1, 0.0)), 0.05, 0.02, 3.0)
    roller = heading + math.pi / 2 + math.radians(30.0)
    (wheel,) = wheels_of(
        project, base, "materials:\n" + material(["wheel"], (math.cos(roller), math.sin(roller), 0), 0.0)
    )
    assert wheel.axle == pytest.approx((-math.sin(heading), math.cos(heading), 0.0))
    assert wheel.roller_angle == pytest.approx(30.0)


def test_a_direction_in_the_frame_of_another_link_is_turned_to_the_base(project: Project) -> None:
    wheels = (Wheel("wheel", 0.1, 0.0, math.pi / 2), Wheel("other", -0.1, 0.0))
    base = Base("one", wheels, 0.05, 0.02, 3.0)
    keys = "materials:\n" + material(["wheel"], (1, 0, 0), 0.0, ", expressed_in: wheel")
    (wheel,) = wheels_of(project, base, keys)
    assert abs(wheel.roller_angle) == pytest.approx(90.0)  # along the wheel's x axis, across its axle


def test_tyres_that_skid_are_wheels_that_roll_ahead(project: Project) -> None:
    found = wheels_of(project, SKID, SKID_WHEELS)
    assert [abs(wheel.roller_angle) for wheel in found] == pytest.approx([90.0] * 4)


def test_wheels_with_the_same_friction_in_all_directions_have_no_rollers(project: Project) -> None:
    keys = f"materials:\n  M: {{dynamic_friction: 0.8, bind: [{', '.join(FOUR)}]}}\n"
    assert wheels_of(project, MECANUM, keys) == ()
