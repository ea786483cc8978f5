"""Friction, track and limits that an import chooses for skid-steered bases."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.bringup.robots.imported_bases import (
    BALLS,
    CONTROLLERS,
    DIFFERENTIAL,
    description,
    imported,
    remarks,
    robot_file,
    slow,
)
from tests.physics.bases import FOUR, SKID, Base, Wheel, four_wheels

TRACK, LENGTH = 0.5708, 0.512
"""Of the base SKID, m."""
CONTROLLER = (
    CONTROLLERS.replace("[left_joint]", "[front_left_joint, rear_left_joint]")
    .replace("[right_joint]", "[front_right_joint, rear_right_joint]")
    .replace("wheel_separation: 0.3", f"wheel_separation: {TRACK}")
    .replace("wheel_radius: 0.05", "wheel_radius: 0.1651")
)
LONG = Base("long", four_wheels(0.8, 0.5), 0.12, 0.08, 30.0)


def parts(found: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """The material of the wheels and the parameters of the base's graph."""
    data = robot_file(found)
    return data["materials"]["wheels"], data["graphs"]["base"]["parameters"]


def friction(along: float, across: float, direction: str = "") -> str:
    """Gazebo's friction of four wheels."""
    fdir1 = f'<fdir1 g:expressed_in="base_link">{direction}</fdir1>' if direction else ""
    tags = f"<mu1>{along}</mu1><mu2>{across}</mu2>{fdir1}"
    return "".join(f'<gazebo reference="{wheel}" xmlns:g="g">{tags}</gazebo>' for wheel in FOUR)


def test_without_friction_and_controller_one_track_serves_all_arcs(tmp_path: Path) -> None:
    found = imported(tmp_path, description(SKID))
    wheels, known = parts(found)
    assert (wheels["dynamic_friction"], wheels["steady_sliding"], wheels["combine"]) == (1.0, True, "max")
    assert wheels["across"] == pytest.approx(0.25 * TRACK / LENGTH, abs=1e-3)
    assert known["track"] == pytest.approx(TRACK * (1 + 0.25**2), rel=1e-3)
    assert (
        "guessed: friction of the skid-steered wheels: 1 along and 0.279 across them, 0.25 track / wheelbase"
        in remarks(found)
    )


@pytest.mark.parametrize(("multiplier", "across"), [(1.875, 1.0), (1.07, 0.279), (1.3, 0.279), (1.4, 1.0)])
def test_the_multiplier_of_a_controller_chooses_the_friction_and_its_track_counts(
    tmp_path: Path, multiplier: float, across: float
) -> None:
    """Equal friction turns with 1.80 of the track, that of one track with 1.06; between them, 1.38 is the geometric mean."""
    text = f"{CONTROLLER}    wheel_separation_multiplier: {multiplier}\n"
    found = imported(tmp_path, description(SKID), text)
    wheels, known = parts(found)
    assert wheels["across"] == across
    assert known["track"] == pytest.approx(TRACK * multiplier, rel=1e-3)
    assert (
        f"carried: track for turns: {TRACK * multiplier:.4g} m, 0.5708 m x {multiplier:g} of DiffDriveController"
        in (remarks(found))
    )


@pytest.mark.parametrize(("aside", "across"), [(0.02, 1.0), (-0.02, 1.0), (0.07, 0.279), (-0.07, 0.279)])
def test_friction_is_not_equal_if_the_mass_lies_to_one_side(tmp_path: Path, aside: float, across: float) -> None:
    """The chassis has 5/6 of the mass; 5 % of the track are 0.0285 m."""
    text = description(SKID).replace("<inertial>", f'<inertial><origin xyz="0 {aside * 6 / 5} 0"/>', 1)
    found = imported(tmp_path, text, f"{CONTROLLER}    wheel_separation_multiplier: 1.875\n")
    wheels, known = parts(found)
    equal = across == 1.0
    assert (wheels["across"], found.draft.controller_track) == (across, equal)
    assert known["track"] == pytest.approx(TRACK * (1.875 if equal else 1 + 0.25**2), rel=1e-3)
    assert ("lost: DiffDriveController base_controller: the track 1.07 m for turns" in remarks(found)) is not equal


def test_the_slippery_friction_of_wheels_that_a_plugin_pushes_does_not_count(tmp_path: Path) -> None:
    plugin = '<gazebo><plugin name="move" filename="libgazebo_ros_planar_move.so"/></gazebo>'
    tags = friction(0.01, 0.01)
    wheels, _ = parts(imported(tmp_path, description(SKID, tags)))
    assert (wheels["dynamic_friction"], wheels["across"]) == (0.01, 0.01)
    found = imported(tmp_path, description(SKID, tags, plugin))
    wheels, _ = parts(found)
    assert (wheels["dynamic_friction"], wheels["across"], wheels["combine"]) == (1.0, 0.279, "max")
    assert f"lost: friction 0.01 of {', '.join(FOUR)}: a plugin drags these wheels over the floor" in remarks(found)
    wheels, _ = parts(imported(tmp_path, description(SKID, friction(0.4, 0.4), plugin)))
    assert (wheels["dynamic_friction"], wheels["across"]) == (0.4, 0.4)


def test_a_controller_without_a_multiplier_does_not_change_the_skid_steered_track(tmp_path: Path) -> None:
    _, known = parts(imported(tmp_path, description(SKID), CONTROLLER))
    assert known["track"] == pytest.approx(TRACK * (1 + 0.25**2), rel=1e-3)


@pytest.mark.parametrize(
    ("tags", "along", "across"),
    [
        (friction(0.9, 0.9), 0.9, 0.9),
        (friction(0.9, 0.4), 0.9, 0.4),
        (friction(0.9, 0.4, "1 0 0"), 0.9, 0.4),
        (friction(0.4, 0.9, "0 1 0"), 0.9, 0.4),
    ],
)
def test_the_friction_of_the_description_is_used(tmp_path: Path, tags: str, along: float, across: float) -> None:
    found = imported(tmp_path, description(SKID, tags))
    wheels, known = parts(found)
    assert (wheels["dynamic_friction"], wheels["across"], wheels["direction"]) == (along, across, [1.0, 0.0, 0.0])
    assert known["track"] == pytest.approx(TRACK * (1 + (across / along * LENGTH / TRACK) ** 2), rel=1e-3)
    assert len(robot_file(found)["materials"]) == 1
    assert (
        f"carried: friction of the skid-steered wheels: {along:g} along and {across:g} across them, of mu1"
        in remarks(found)
    )


def test_guessed_limits_keep_the_force_towards_the_centre_below_a_share_of_the_grip(tmp_path: Path) -> None:
    wheels, known = parts(imported(tmp_path, description(SKID)))
    assert known["speed"] == 0.5
    assert known["speed"] * known["turn"] <= 0.15 * wheels["across"] * 9.81
    assert known["speed"] * known["turn"] == pytest.approx(0.15 * wheels["across"] * 9.81, rel=0.01)
    wheels, known = parts(imported(tmp_path, description(SKID, friction(1.0, 1.0))))
    assert known["turn"] == 1.5
    assert known["speed"] == pytest.approx(0.15 * 9.81 / 1.5, abs=0.002)


def test_limits_of_joints_and_controllers_stay(tmp_path: Path) -> None:
    _, known = parts(imported(tmp_path, slow(description(SKID), 2.0)))
    assert known["speed"] == pytest.approx(2.0 * 0.1651, abs=0.002)  # below 0.5, as the wheels are slow
    text = f"{CONTROLLER}    linear.x.max_velocity: 0.7\n    angular.z.max_velocity: 2.5\n"
    _, known = parts(imported(tmp_path, description(SKID), text))
    assert (known["speed"], known["turn"]) == (0.7, 2.5)


def test_a_long_base_has_a_remark_on_the_slope_at_which_it_slides(tmp_path: Path) -> None:
    """0.25 x 0.5 / 0.8 = 0.156, the tangent of 8.9 degrees."""
    found = imported(tmp_path, description(LONG))
    assert parts(found)[0]["across"] == 0.156
    slope = math.degrees(math.atan(0.156))
    assert f"noticed: parked across a slope, the robot slides from {slope:.1f} degrees on" in remarks(found)
    assert "parked across a slope" not in remarks(imported(tmp_path, description(SKID)))


@pytest.mark.parametrize(("offset", "side"), [(-0.05, "behind"), (0.05, "ahead of"), (0.02, "")])
def test_a_skid_steered_base_has_a_remark_on_a_mass_ahead_of_or_behind_its_middle(
    tmp_path: Path, offset: float, side: str
) -> None:
    """The wheels have a sixth of the mass; remarks begin at 0.05 of the wheelbase, 26 mm."""
    said = remarks(imported(tmp_path, description(replace(SKID, centre=(1.2 * offset, 0.0)))))
    expected = (
        f"noticed: the centre of mass lies 50 mm {side} the middle of its wheels, so the skid-steered base turns about"
    )
    assert (expected in said) is bool(side)
    assert ("centre of mass" in said) is bool(side)


@pytest.mark.parametrize("names", [("front_caster", "rear_caster", 0.05), ("front", "rear", 0.03)])
def test_two_fixed_rolling_casters_are_not_skid_steering(tmp_path: Path, names: tuple[str, str, float]) -> None:
    front, rear, radius = names
    casters = Base("x", (Wheel(front, 0.15, 0.0), Wheel(rear, -0.15, 0.0)), radius, 0.02, 0.5)
    inside = casters.urdf().partition("</link>")[2].removesuffix("</robot>")
    inside = inside.replace('0.0 0"', f'0.0 {radius - 0.05}"')
    commands = "".join(
        f'<joint name="{side}_joint"><command_interface name="velocity"/></joint>' for side in ("left", "right")
    )
    control = f'<ros2_control name="base" type="system">{commands}</ros2_control>'
    text = DIFFERENTIAL.urdf().replace("</robot>", f"{inside}{control}</robot>")
    assert BALLS not in text
    found = imported(tmp_path, text)
    data = robot_file(found)
    assert data["graphs"]["base"]["parameters"]["track"] == 0.3
    assert data["materials"]["casters"]["across"] == 0.0
    assert sorted(data["materials"]["casters"]["bind"]) == sorted([front, rear])
    assert "skid-steered" not in remarks(found)
