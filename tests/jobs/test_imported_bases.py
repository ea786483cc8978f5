"""A base moves as it is told once its description was imported, in whichever way that description tells of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from graphengine.bringup.calibration.arc_track import correct_track
from graphengine.messages import messages
from tests.bringup.robots.imported_bases import (
    BASES,
    CAR,
    CONTROLLERS,
    DIFFERENTIAL,
    PLUGIN,
    description,
    imported,
    imported_sdf,
    interfaces,
    remarks,
    robot_file,
    scene,
    sdf,
    slow,
)
from tests.jobs.harness import Job
from tests.physics.bases import FOUR, SKID, Base, Wheel

Twist = tuple[float, float, float]


def driven(folder: Path, base: Base, command: Twist, *more: str, controllers: str = "") -> Twist:
    """The velocity of an imported base."""
    return moved(scene(folder, imported(folder, description(base, *more), controllers)), command)


def moved(path: Path, command: Twist, topic: str = "/ground_truth/odom", seconds: float = 4.0) -> Twist:
    """The velocity (ahead, to the left, turn rate) by a topic, of a robot that was told one for some seconds."""
    with Job(path) as job:
        x, y, turn = command
        told = messages.Twist(messages.Vector3(x, y, 0.0), messages.Vector3(0.0, 0.0, turn))
        for tick in range(round(seconds * job.rate)):
            if tick % 6 == 0:
                job.transport.inject("/cmd_vel", told)
            job.session.step()
        seen = [message.twist.twist for message in job.heard(topic)[-60:]]
    means = np.mean([(each.linear.x, each.linear.y, each.angular.z) for each in seen], axis=0)
    return float(means[0]), float(means[1]), float(means[2])


FORMS = {
    "plain": ((), ""),
    "with Gazebo's plugin": ((PLUGIN,), ""),
    "with ros2_control": ((interfaces(left_joint="velocity", right_joint="velocity"),), CONTROLLERS),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("command", [(0.5, 0.0, 0.0), (0.0, 0.0, 0.8), (0.3, 0.0, -0.4)])
def test_a_differential_base_moves_alike_in_every_form(tmp_path: Path, form: str, command: Twist) -> None:
    more, controllers = FORMS[form]
    reached = driven(tmp_path, DIFFERENTIAL, command, *more, controllers=controllers)
    assert reached == pytest.approx(command, rel=0.005, abs=0.002)


@pytest.mark.parametrize("more", [(), (PLUGIN,)], ids=["plain", "with Gazebo's plugin"])
@pytest.mark.parametrize("command", [(0.5, 0.0, 0.0), (0.0, 0.0, 0.8), (0.3, 0.0, -0.4)])
def test_a_differential_base_of_sdf_moves_as_that_of_urdf(
    tmp_path: Path, more: tuple[str, ...], command: Twist
) -> None:
    reached = moved(scene(tmp_path, imported_sdf(tmp_path, sdf(DIFFERENTIAL, *more))), command)
    assert reached == pytest.approx(driven(tmp_path, DIFFERENTIAL, command, *more), rel=0.001, abs=0.0005)
    assert reached == pytest.approx(command, rel=0.005, abs=0.002)


@pytest.mark.parametrize("command", [(1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.2, 0.0, -5.0)])
def test_a_base_with_slow_wheels_drives_the_commanded_arc_as_fast_as_its_wheels_allow(
    tmp_path: Path, command: Twist
) -> None:
    rim, lever = 8.0 * DIFFERENTIAL.radius, 0.15
    reached = moved(scene(tmp_path, imported(tmp_path, slow(description(DIFFERENTIAL), 8.0))), command)
    speed, turn = min(command[0], rim), math.copysign(min(abs(command[2]), 2.0), command[2])
    share = min(1.0, rim / (speed + abs(turn) * lever))
    assert reached == pytest.approx((speed * share, 0.0, turn * share), rel=0.01, abs=0.002)


def test_a_differential_base_has_the_same_drives_in_every_form(tmp_path: Path) -> None:
    files = [robot_file(imported(tmp_path, description(DIFFERENTIAL, *more), yaml)) for more, yaml in FORMS.values()]
    for key in ("joints", "materials", "wheel_colliders", "graphs"):
        assert files[0][key] == files[1][key] == files[2][key]


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("mecanum", (0.3, 0.0, 0.0)),
        ("mecanum", (0.0, 0.3, 0.0)),
        ("mecanum", (0.0, 0.0, 0.6)),
        ("mecanum", (0.2, -0.2, 0.3)),
        ("skid", (0.5, 0.0, 0.0)),
        ("car", (0.5, 0.0, 0.0)),
        ("car", (0.5, 0.0, 0.5)),
        ("car", (-0.4, 0.0, 0.3)),
    ],
)
def test_a_base_whose_description_has_no_drives_moves_as_commanded(tmp_path: Path, name: str, command: Twist) -> None:
    """A car turns about a point beside its rear axle, which is 0.2 m behind the base link."""
    x, y, turn = command
    reached = driven(tmp_path, BASES[name], command)
    assert reached == pytest.approx((x, y + 0.2 * turn if name == "car" else y, turn), rel=0.01, abs=0.01)


def test_a_skid_steered_base_turns_as_commanded_with_the_multiplier_of_its_controller(tmp_path: Path) -> None:
    left, right = (f"[front_{side}_joint, rear_{side}_joint]" for side in ("left", "right"))
    controllers = CONTROLLERS.replace("[left_joint]", left).replace("[right_joint]", right).replace("0.3", "0.5708")
    controllers = controllers.replace(
        "wheel_radius: 0.05", "wheel_radius: 0.1651\n    wheel_separation_multiplier: 1.8"
    )
    assert driven(tmp_path, SKID, (0.0, 0.0, 0.6), controllers=controllers)[2] == pytest.approx(0.6, rel=0.01)


def test_wheels_that_nobody_commands_do_not_brake(tmp_path: Path) -> None:
    """Two of four wheels are driven; as brakes, the others would hold the base."""
    control = interfaces(rear_left_joint="velocity", rear_right_joint="velocity", front_left_joint="")
    found = imported(tmp_path, description(SKID, control))
    joints = robot_file(found)["joints"]
    assert ["drive" in joints[f"{wheel}_joint"] for wheel in FOUR] == [False, False, True, True]
    assert driven(tmp_path, SKID, (0.5, 0.0, 0.0), control)[0] == pytest.approx(0.5, rel=0.01)


def test_the_odometry_of_a_car_follows_its_true_motion(tmp_path: Path) -> None:
    path = scene(tmp_path, imported(tmp_path, description(CAR)))
    with Job(path) as job:
        job.drive("/cmd_vel", 0.5, 0.5, 4.0)
        odometry, truth = (job.heard(topic)[-1].pose.pose.position for topic in ("/odom", "/ground_truth/odom"))
    assert (odometry.x, odometry.y) == pytest.approx((truth.x, truth.y), abs=0.04)


def test_the_graph_is_named_with_its_source(tmp_path: Path) -> None:
    assert "guessed: base: skid-steered with 4 driven wheels" in remarks(imported(tmp_path, description(SKID)))


@pytest.mark.parametrize("command", [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.1, -0.2, 0.5)])
def test_a_base_on_three_omnidirectional_wheels_moves_as_commanded(tmp_path: Path, command: Twist) -> None:
    angles = [math.radians(degrees) for degrees in (60, 180, 300)]
    wheels = [Wheel(f"w{n}", 0.2 * math.cos(a), 0.2 * math.sin(a), a - math.pi / 2) for n, a in enumerate(angles)]
    base = Base("omni", tuple(wheels), 0.05, 0.02, 5.0)
    path = scene(tmp_path, imported(tmp_path, description(base)))
    assert moved(path, command, "/odom") == pytest.approx(command, rel=0.01, abs=0.005)


TRICYCLE = Base(
    "tricycle",
    (Wheel("front", 0.3, 0.0, steering=1), Wheel("left", -0.2, 0.15), Wheel("right", -0.2, -0.15)),
    0.05,
    0.03,
    5.0,
)
FORKLIFT = Base(
    "forklift",
    (
        Wheel("front_left", 0.2, 0.15),
        Wheel("front_right", 0.2, -0.15),
        Wheel("rear_left", -0.2, 0.15, steering=1),
        Wheel("rear_right", -0.2, -0.15, steering=1),
    ),
    0.05,
    0.03,
    5.0,
)
STEERED = {
    "two wheels behind": (TRICYCLE, interfaces(front_steer="position", left_joint="velocity", right_joint="velocity")),
    "the wheel that steers": (TRICYCLE, interfaces(front_steer="position", front_joint="velocity")),
    "two wheels before those that steer": (
        FORKLIFT,
        interfaces(
            rear_left_steer="position",
            rear_right_steer="position",
            front_left_joint="velocity",
            front_right_joint="velocity",
        ),
    ),
}


@pytest.mark.parametrize("driving", STEERED)
@pytest.mark.parametrize("turn", [0.4, -0.4])
def test_a_base_with_any_driven_and_steered_wheels_moves_as_commanded_and_its_odometry_agrees(
    tmp_path: Path, driving: str, turn: float
) -> None:
    base, hardware = STEERED[driving]
    path = scene(tmp_path, imported(tmp_path, description(base, hardware)))
    for topic in ("/ground_truth/odom", "/odom"):
        ahead, _, turned = moved(path, (0.5, 0.0, turn), topic)
        assert (ahead, turned) == pytest.approx((0.5, turn), rel=0.02)


FRONT_WHEELS = PLUGIN.replace("left_joint<", "front_left_joint<").replace("right_joint<", "front_right_joint<")
FOLLOWING = [
    (f'<joint name="rear_{side}_joint" type="continuous">', f'<mimic joint="front_{side}_joint"/>')
    for side in ("left", "right")
]


@pytest.mark.parametrize("form", ["two driven", "two followed"])
def test_four_parallel_wheels_of_which_two_are_commanded_turn_as_commanded(tmp_path: Path, form: str) -> None:
    text = description(SKID, *([FRONT_WHEELS] if form == "two driven" else []))
    for joint, mimic in FOLLOWING if form == "two followed" else ():
        text = text.replace(joint, joint + mimic)
    found = imported(tmp_path, text)
    path = scene(tmp_path, found)
    correct_track(tmp_path / "robots/bot.yaml", "bot", found.lift, found.outside, told=False)  # as `graphrun new` does
    _, _, turned = moved(path, (0.15, 0.0, 0.24))
    assert turned == pytest.approx(0.24, rel=0.02)
