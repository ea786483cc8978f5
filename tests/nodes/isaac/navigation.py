"""Cases of QuinticPathPlanner, CheckGoal2D and StanleyControlPID."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.nodes.wheeled_robots.check_goal import CheckGoal2D
from graphengine.nodes.wheeled_robots.planar import wrapped
from graphengine.nodes.wheeled_robots.quintic import QuinticPathPlanner
from graphengine.nodes.wheeled_robots.stanley import StanleyControlPID
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import Case, made, runs

PREFIX = "isaacsim.robot.wheeled_robots"
NOWHERE = (0.0, 0.0, 0.0, 0.0)


@runs("QuinticPathPlanner", "impossible limits")
def without_acceleration_there_is_no_path(case: Case, play: Player) -> None:
    given = case["inputs"]
    assert (given["start"][2], given["goal"][2], case["expect"]["raises"]) == (0, 0, "ValueError")
    node = ready(
        QuinticPathPlanner,
        RecordingContext(),
        current_position=given["start"],
        target_position=given["goal"],
        initial_velocity=given["v"],
        goal_velocity=given["v"],
        initial_accel=given["a"],
        goal_accel=given["a"],
        max_accel=given["max_accel"],
        max_jerk=given["max_jerk"],
        step=given["dt"],
    )
    with pytest.raises(ValueError, match="maxAccel"):
        node.compute()


@runs("stanley.normalize_angle", "wrap")
def angles_are_within_half_a_turn(case: Case, play: Player) -> None:
    angles = [float(text.removesuffix("pi")) * math.pi for text in case["inputs"]["angles"]]
    assert [wrapped(angle) for angle in angles] == pytest.approx(case["expect"]["result"], abs=case["tolerance"])


@runs(f"{PREFIX}.CheckGoal2D", "default zero quaternion")
def a_base_without_orientation_looks_along_x(case: Case, play: Player) -> None:
    node = made(CheckGoal2D, case)
    node.compute()
    assert node.reached_goal.tolist() == case["expect"]["outputs:reachedGoal"]


@runs(f"{PREFIX}.QuinticPathPlanner", "default zero quaternions")
def a_path_between_places_without_orientation_is_finite(case: Case, play: Player) -> None:
    node = made(QuinticPathPlanner, case, current_orientation=NOWHERE, target_orientation=NOWHERE)
    node.setup(RecordingContext())
    node.compute()
    assert np.isfinite(node.target).all()
    assert len(node.path_arrays) > 0
    assert np.isfinite(node.path_arrays).all()


@runs(f"{PREFIX}.StanleyControlPID", "default zero quaternion")
def a_base_without_orientation_is_told_finite_speeds(case: Case, play: Player) -> None:
    node = made(StanleyControlPID, case, current_orientation=NOWHERE, path_arrays=[])
    node.compute()
    assert case["expect"] == {"outputs": "finite"}
    assert np.isfinite((node.linear_velocity, node.angular_velocity)).all()
