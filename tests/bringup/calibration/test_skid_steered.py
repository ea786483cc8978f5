"""Skid-steered robots straight from an import: the track that test drives find, and how the robots move with it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

import graphengine as ge
from graphengine import bringup
from graphengine.bringup.calibration.arc_track import correct_track, lower_turn
from graphengine.bringup.calibration.figures import Twist
from tests.bringup.robots.imported_bases import PLUGIN, description, imported, robot_file, scene, slow
from tests.bringup.robots.test_skid_steering import CONTROLLER, LENGTH, LONG, TRACK, friction
from tests.physics.bases import SKID, Base, Wheel
from tests.physics.dynamics.coulomb_balance import turning_track


def corrected(folder: Path, text: str, controllers: str = "") -> tuple[Path, str]:
    """Import a robot, correct its track, and return its scene and what the correction says."""
    found = imported(folder, text, controllers)
    path = scene(folder, found)
    told = found.draft.controller_track
    assert told is not None
    return path, correct_track(folder / "robots/bot.yaml", "bot", found.lift, found.outside, told=told)


def parameters(path: Path) -> dict[str, float]:
    """The parameters of the graph of the robot's base."""
    data = yaml.safe_load((path.parent / "robots/bot.yaml").read_text(encoding="utf-8"))
    values: dict[str, float] = data["graphs"]["base"]["parameters"]
    return values


def arc(loaded: ge.Scene, speed: float, turn: float) -> tuple[float, float, float]:
    """Forward speed (m/s), turn rate (rad/s) and sideslip (rad) of a robot that drives on an arc."""
    with loaded.session() as sim:
        robot = sim.robots["bot"]
        robot.publish("cmd_vel", {"linear": {"x": speed}, "angular": {"z": turn}}, every=0.05)
        sim.run(3.0)
        places = []
        for _ in range(120):
            sim.step()
            (x, y, _), (qx, qy, qz, qw) = robot.pose.position, robot.pose.orientation
            places.append((x, y, math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))))
    path_, yaw = np.array(places)[:, :2], np.unwrap(np.array(places)[:, 2])
    moved, middle = np.diff(path_, axis=0) * 60.0, (yaw[1:] + yaw[:-1]) / 2
    ahead = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
    aside = moved[:, 1] * np.cos(middle) - moved[:, 0] * np.sin(middle)
    return float(ahead.mean()), float(np.diff(yaw).mean() * 60.0), math.atan2(aside.mean(), ahead.mean())


@pytest.mark.parametrize(
    ("tags", "controllers"),
    [("", ""), (friction(1.0, 1.0), ""), ("", f"{CONTROLLER}    wheel_separation_multiplier: 1.8\n")],
    ids=["one track", "mu1", "controller"],
)
def test_a_new_skid_steered_robot_follows_arcs_within_its_limits(tmp_path: Path, tags: str, controllers: str) -> None:
    path, _ = corrected(tmp_path, description(SKID, tags), controllers)
    known, loaded = parameters(path), ge.load(path)
    for share in (0.3, 1.0):
        for spin in (0.3, 1.0, -1.0):
            speed, turn = share * known["speed"], spin * share * known["turn"]
            ahead, rate, slip = arc(loaded, speed, turn)
            assert ahead >= 0.95 * speed
            assert 0.9 <= rate / turn <= 1.1, (speed, turn)
            assert abs(slip) <= math.atan(abs(turn) * LENGTH / 2 / speed) + math.radians(15.0)


CORNERS = [
    ("front_left", 0.7, 0.55),
    ("front_right", 0.7, -0.55),
    ("rear_left", -0.7, 0.55),
    ("rear_right", -0.7, -0.55),
]
LARGE = Base("large", tuple(Wheel(*corner) for corner in CORNERS), 0.1, 0.08, 200.0)
"""With equal friction in all directions it slides outwards by an angle that grows with its size and its turn rate squared."""


def lowered(folder: Path, controllers: str = "") -> tuple[Path, float, list[str]]:
    """Import the large robot, correct its track and limit, and return its scene, its limit before, and what was corrected."""
    found = imported(folder, description(LARGE, friction(1.0, 1.0)), controllers)
    path = scene(folder, found)
    robot = folder / "robots/bot.yaml", "bot", found.lift, found.outside
    correct_track(*robot, told=False)
    before = parameters(path)["turn"]
    return path, before, lower_turn(*robot, guessed=found.draft.guessed_turn)


def test_a_guessed_limit_with_which_a_large_base_slides_outwards_is_lowered(tmp_path: Path) -> None:
    path, before, (said,) = lowered(tmp_path)
    known, loaded = parameters(path), ge.load(path)
    assert said.startswith(
        f"limit of the skid-steered base: turn {known['turn']:g} rad/s in place of {before:g} rad/s: "
    )
    ahead, rate, slip = arc(loaded, known["speed"], known["turn"])
    assert ahead >= 0.95 * known["speed"]
    assert rate == pytest.approx(known["turn"], rel=0.1)
    # Small angles by Coulomb's law, with half the wheelbase b, its ratio q to half the track, and the floor's friction 0.8.
    b, q = 0.7, 0.7 / 0.55
    expected = known["turn"] ** 2 * b * (1 + q**2) ** 1.5 / q**2 / (0.8 * 9.81)
    assert math.tan(abs(slip)) == pytest.approx(expected, rel=0.25)


def test_limits_of_a_base_with_slow_wheels_are_not_lowered(tmp_path: Path) -> None:
    found = imported(tmp_path, slow(description(SKID), 3.0))
    path, before = scene(tmp_path, found), robot_file(found)["graphs"]["base"]["parameters"]
    robot = tmp_path / "robots/bot.yaml", "bot", found.lift, found.outside
    correct_track(*robot, told=False)
    assert lower_turn(*robot, guessed=True) == []
    assert parameters(path)["turn"] == before["turn"]


def test_the_track_of_a_skid_steered_base_with_two_driven_wheels_is_not_said_to_be_wrong(tmp_path: Path) -> None:
    """Its track is (1 + 0.25^2) times the distance of the wheels, which a base of two wheels would need."""
    plugin = PLUGIN.replace("left_joint<", "front_left_joint<").replace("right_joint<", "front_right_joint<")
    path = scene(tmp_path, imported(tmp_path, description(SKID, plugin)))
    assert parameters(path)["track"] > 1.05 * TRACK
    assert "W202" not in [finding.code for finding in ge.load(path).findings]


def test_arcs_are_measured_after_a_slow_ramp(tmp_path: Path) -> None:
    """At 0.25 m/s2, the base turns steadily long before it drives at its full speed of 1 m/s."""
    slowly = "    linear.x.max_velocity: 1.0\n    linear.x.max_acceleration: 0.25\n"
    path, _ = corrected(tmp_path, description(SKID), f"{CONTROLLER}{slowly}")
    before = parameters(path)["turn"]
    assert lower_turn(tmp_path / "robots/bot.yaml", "bot", 0.0, [], guessed=True) == []
    assert parameters(path)["turn"] == before
    arcs = [each for each in bringup.calibrate(ge.load(path)).motions if "full_arc" in each.name]
    assert len(arcs) == 2
    assert all(each.speed_share is not None and each.speed_share > 0.95 for each in arcs)


@pytest.mark.parametrize("limits", ["", "    angular.z.max_velocity: 1.5\n    linear.x.max_velocity: 0.98\n"])
def test_wheels_without_grip_across_them_get_no_track_and_no_guessed_limit(tmp_path: Path, limits: str) -> None:
    """A limit of 0 in a graph would mean no limit."""
    path, said = corrected(tmp_path, description(SKID, friction(1.0, 0.0)), f"{CONTROLLER}{limits}")
    assert said.startswith("track: not measured, because")
    assert parameters(path).get("turn", 1.5) == 1.5


def test_a_limit_of_the_description_stays_and_is_reported(tmp_path: Path) -> None:
    limits = "    angular.z.max_velocity: 1.5\n    linear.x.max_velocity: 0.98\n"
    path, before, (said,) = lowered(tmp_path, f"{CONTROLLER}{limits}")
    assert parameters(path)["turn"] == before == 1.5
    assert said.startswith(
        "limits too high for the skid-steered base: on arcs of 0.98 m/s and 1.5 rad/s, it skids and reaches"
    )
    assert said.endswith("; lower `turn` of its graph")


def test_a_skid_steered_robot_whose_mass_lies_to_one_side_follows_arcs(tmp_path: Path) -> None:
    """With equal friction, the wheels on the light side slide more, and the robot turns about a point 0.16 m from its middle."""
    text = description(SKID).replace("<inertial>", '<inertial><origin xyz="0 -0.085 0"/>', 1)
    path, _ = corrected(tmp_path, text, f"{CONTROLLER}    wheel_separation_multiplier: 1.875\n")
    loaded = ge.load(path)
    for turn in (0.3, -0.3):
        ahead, rate, _ = arc(loaded, 0.3, turn)
        assert ahead == pytest.approx(0.3, rel=0.02)
        assert rate == pytest.approx(turn, rel=0.05)


def test_the_track_of_a_controller_is_kept_if_the_robot_turns_with_it(tmp_path: Path) -> None:
    path, said = corrected(tmp_path, description(SKID), f"{CONTROLLER}    wheel_separation_multiplier: 1.85\n")
    assert parameters(path)["track"] == pytest.approx(0.5708 * 1.85, rel=1e-3)
    assert "of the controller, with which it turns at 10" in said


def test_a_controllers_track_with_wrong_turn_rates_is_replaced(tmp_path: Path) -> None:
    path, said = corrected(tmp_path, description(SKID), f"{CONTROLLER}    wheel_separation_multiplier: 2.5\n")
    track = parameters(path)["track"]
    assert track == pytest.approx(0.5708 * (1 + (LENGTH / 0.5708) ** 2), rel=0.03)
    assert f"track: {track:.4g} m, with which the robot turns as commanded on arcs" in said
    assert said.endswith(f"; with {0.5708 * 2.5:.4g} m of the controller, it turns at {0.5708 * 2.5 / track:.1%}")


@pytest.mark.parametrize("centre", [(0.0, -0.085), (-0.072, 0.0)], ids=["side-heavy", "tail-heavy"])
def test_the_track_of_a_base_with_uneven_loads_agrees_with_the_balance_of_coulomb_forces(
    tmp_path: Path, centre: tuple[float, float]
) -> None:
    """Equal friction would turn an evenly loaded base with 1.80 of the distance of the wheels: these with 2.04 and 1.57."""
    base = replace(SKID, centre=centre)
    path, said = corrected(
        tmp_path, description(base, friction(1.0, 1.0)), f"{CONTROLLER}    wheel_separation_multiplier: 1.8\n"
    )
    known = parameters(path)
    expected = turning_track(base, 1.0, 0.3 * known["speed"], 0.3 * known["turn"])
    assert known["track"] == pytest.approx(expected, rel=0.02)
    assert "of the controller, it turns at" in said


def test_a_track_several_times_that_of_the_controller_is_found_although_the_limits_cap_the_turn_rate(
    tmp_path: Path,
) -> None:
    """Equal friction turns with 3.56 of the distance of the wheels; the arcs have 0.3 of the limits."""
    sizes = CONTROLLER.replace("0.5708", "0.5").replace("0.1651", "0.12")
    limits = "    linear.x.max_velocity: 0.5\n    angular.z.max_velocity: 0.5\n"
    text = description(LONG, friction(1.0, 1.0))
    path, said = corrected(tmp_path, text, f"{sizes}    wheel_separation_multiplier: 1.03\n{limits}")
    assert parameters(path)["track"] == pytest.approx(0.5 * (1 + (0.8 / 0.5) ** 2), rel=0.02)
    assert "turns as commanded on arcs" in said


def test_if_no_track_gives_the_commanded_turn_rate_the_best_one_tried_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tracks: list[float] = []

    def drive(_: object, speed: float, turn: float, track: float) -> tuple[Twist, Twist]:
        tracks.append(track)
        reached = (1.2, 0.9, 1.03, 0.95, 1.1)[len(tracks) - 1] * turn
        return Twist(x=speed, yaw=reached), Twist(x=speed, yaw=-reached)

    monkeypatch.setattr("graphengine.bringup.calibration.arc_track.ArcDrives.drive", drive)
    path, said = corrected(tmp_path, description(SKID), f"{CONTROLLER}    wheel_separation_multiplier: 1.85\n")
    expected = 0.5708 * 1.85 / 1.2 / 0.9
    assert tracks[2] == pytest.approx(expected, rel=1e-4)
    assert parameters(path)["track"] == pytest.approx(tracks[2], rel=1e-4)
    assert len(tracks) == 5
    assert f"track: {expected:.4g} m, with which the robot turns at 103.0% of commands" in said


def test_encoder_odometry_of_a_skidding_base_drifts_and_the_true_odometry_does_not(tmp_path: Path) -> None:
    path, _ = corrected(tmp_path, description(SKID))
    result = bringup.calibrate(ge.load(path))
    errors = {one.topic: one for one in result.odometry}
    assert errors["/ground_truth/odom"].is_true()
    assert abs(errors["/odom"].turn_error or 0.0) > math.radians(1.0)
    assert all(motion.skids for motion in result.motions)
    assert result.track == pytest.approx(parameters(path)["track"], rel=0.01)  # noise of encoders has no part in it
    assert result.outside(0.02) == ()


def test_the_file_of_a_new_robot_is_as_written_but_for_its_track(tmp_path: Path) -> None:
    found = imported(tmp_path, description(SKID), f"{CONTROLLER}    wheel_separation_multiplier: 2.5\n")
    before = robot_file(found)
    path, _ = corrected(tmp_path, description(SKID), f"{CONTROLLER}    wheel_separation_multiplier: 2.5\n")
    after = parameters(path)
    assert {key for key, value in before["graphs"]["base"]["parameters"].items() if after[key] != value} == {"track"}


def test_a_guessed_limit_is_kept_if_no_lower_limit_helps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    driven: list[float] = []

    def drive(_: object, speed: float, turn: float) -> tuple[Twist, Twist]:
        driven.append(turn)
        return Twist(x=speed, yaw=0.6 * turn), Twist(x=speed, yaw=-turn)

    monkeypatch.setattr("graphengine.bringup.calibration.arc_track.ArcDrives.drive", drive)
    found = imported(tmp_path, description(SKID))
    path, before = scene(tmp_path, found), robot_file(found)["graphs"]["base"]["parameters"]
    (said,) = lower_turn(tmp_path / "robots/bot.yaml", "bot", found.lift, found.outside, guessed=True)
    assert parameters(path)["turn"] == before["turn"]
    assert driven == pytest.approx([before["turn"] * 0.8**tries for tries in range(5)])
    assert "it skids and reaches 100% of the speed and 60% of the turn rate" in said
    lowest = f"on arcs of 0.5 m/s and {driven[-1]:.3g} rad/s, it skids and reaches 100% of the speed and 60% of the turn rate"
    assert said.endswith(f"; even {lowest}")


def test_a_guessed_limit_is_lowered_until_slow_arcs_are_as_commanded_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The base loses speed on slow arcs only, until the limit is 0.8 of 0.8 of the guessed one."""
    driven: list[tuple[float, float]] = []
    found = imported(tmp_path, description(SKID))
    path, known = scene(tmp_path, found), robot_file(found)["graphs"]["base"]["parameters"]

    def drive(_: object, speed: float, turn: float) -> tuple[Twist, Twist]:
        driven.append((speed / known["speed"], turn / known["turn"]))
        loses = speed < known["speed"] and turn > 0.2 * known["turn"]
        reached = 0.84 * speed if loses else speed
        return Twist(x=reached, yaw=turn), Twist(x=reached, yaw=-turn)

    monkeypatch.setattr("graphengine.bringup.calibration.arc_track.ArcDrives.drive", drive)
    (said,) = lower_turn(tmp_path / "robots/bot.yaml", "bot", found.lift, found.outside, guessed=True)
    rates = [(1.0, 1.0), (0.3, 0.3), (1.0, 0.8), (0.3, 0.24), (1.0, 0.64), (0.3, 0.192)]
    assert np.array(driven) == pytest.approx(np.array(rates), rel=0.01)
    assert parameters(path)["turn"] == pytest.approx(0.64 * known["turn"], rel=0.01)
    assert (
        f"on arcs of {0.3 * known['speed']:.3g} m/s and {0.3 * known['turn']:.3g} rad/s, it skids and reaches 84%"
        in said
    )
