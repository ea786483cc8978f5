"""Cases of AckermannController."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from graphengine.nodes.wheeled_robots.ackermann import AckermannController
from tests.nodes import scenes
from tests.nodes.harness import Player
from tests.nodes.isaac.book import Case, made, runs

ACKERMANN = "isaacsim.robot.wheeled_robots.AckermannController"


def outputs(node: AckermannController) -> dict[str, list[float]]:
    node.compute()
    return {"wheelAngles": node.wheel_angles.tolist(), "wheelRotationVelocity": node.wheel_rotation_velocity.tolist()}


@runs(ACKERMANN, "instant case1", "instant case2 tiny steer (<0.0157 rad -> straight)")
def without_ramps_the_wheels_follow_at_once(case: Case, play: Player) -> None:
    found = outputs(made(AckermannController, case))
    for name, expected in case["expect"].items():
        assert found[name] == pytest.approx(expected, abs=case["tolerance"], rel=0.0)


@runs(ACKERMANN, "ramp case 2", "ramp case 3")
def ramps_reach_the_target_in_their_time(case: Case, play: Player) -> None:
    node = made(AckermannController, case)
    trace = [outputs(node) for _ in range(case["inputs"]["iterations"] + 1)]
    for name, phases in case["expect"].items():
        before, after = sorted(phases)
        reached = int(re.sub(r"\D", "", before))
        final = np.array(phases[after]["value"])
        assert all(np.all(np.array(step[name]) < final) for step in trace[:reached])
        assert all(step[name] == pytest.approx(final, abs=phases[after]["tol"], rel=0.0) for step in trace[reached:])


@runs(ACKERMANN, "forklift closed loop")
def a_forklift_drives_the_circle_that_it_steers(case: Case, play: Player) -> None:
    playing = play.scene(scenes.forklift(case["inputs"])).tick(180)
    node: Any = playing.node("Compute")
    found = (node.linear_velocity[0], node.angular_velocity[2], node.linear_acceleration[0])
    assert all(tolerance >= 0.01 for tolerance in case["tolerance"].values())
    assert found == pytest.approx(tuple(case["expect"].values()), abs=0.01)
