"""Cases of HolonomicController."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.nodes.wheeled_robots.holonomic import HolonomicController
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, matrix
from tests.nodes.isaac.book import Case, differs, made, runs

HOLONOMIC = "isaacsim.robot.wheeled_robots.HolonomicController"
CLASS = "HolonomicController (python class)"


@runs(HOLONOMIC, "kaya 3-wheel")
@runs(CLASS, "class kaya")
def three_wheels(case: Case, play: Player) -> None:
    node = made(HolonomicController, case)
    node.compute()
    (expected,) = case["expect"].values()
    assert node.joint_velocity_command.tolist() == pytest.approx(expected, abs=case["tolerance"], rel=0.0)


@runs(CLASS, "pure forward gives positive net x")
def contributions_forward_are_positive(case: Case, play: Player) -> None:
    node = made(HolonomicController, case)
    node.compute()
    angles, forward = case["inputs"]["mecanumAngles"], 0.0
    for speed, angle, (w, x, y, z) in zip(
        node.joint_velocity_command.tolist(), angles, case["inputs"]["wheelOrientations"], strict=True
    ):
        half = math.radians(angle) / 2
        turned = matrix((0.0, 0.0, math.sin(half), math.cos(half))) @ matrix((x, y, z, w)) @ np.array([1.0, 0.0, 0.0])
        forward += speed * turned[0]
    assert forward > case["expect"]["dot(base_dir_x, result)"]["gt"]


@runs(CLASS, "missing required array -> ValueError")
def without_an_array_it_refuses(case: Case, play: Player) -> None:
    whole: dict[str, Any] = {"wheel_radius": [0.04] * 3, "mecanum_angles": [90.0] * 3}
    whole |= {"wheel_positions": [[0.1, 0, 0], [0, 0.1, 0], [0, -0.1, 0]], "wheel_orientations": [[1, 0, 0, 0]] * 3}
    assert case["expect"]["raises"] == "ValueError"
    for missing in case["inputs"]["missing_any_of"]:
        with pytest.raises(ValueError, match=r"wheel[RPO]|mecanumAngles"):
            HolonomicController(**{name: value for name, value in whole.items() if name != missing}).compute()


@differs(HOLONOMIC, "stop zeroes output")
def output_after_a_stop(case: Case, play: Player) -> Any:
    node = made(HolonomicController, case)
    node.compute()
    RecordingContext().stop(node)
    return node.joint_velocity_command.tolist()
