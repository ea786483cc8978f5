"""What an environment refuses: wrong addresses, limits and sizes, and a missing gymnasium."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import graphengine as ge
from tests.api.gym.conftest import CMD_VEL, ODOM, Make

WRONG: list[tuple[dict[str, Any], str]] = [
    (
        {"action": ge.gym.BaseVelocity("/dd100_0000/cmd_vle")},
        "no graph uses topic '/dd100_0000/cmd_vle'\n  did you mean",
    ),
    ({"action": ge.gym.BaseVelocity(ODOM)}, "nav_msgs/msg/Odometry has no field 'linear'; fields: header"),
    ({"action": ge.gym.BaseVelocity(CMD_VEL, linear=-1.0)}, f"{CMD_VEL}: expected low below high"),
    ({"action": ge.gym.JointTargets("dd10", "positions")}, "no robot 'dd10'\n  did you mean 'dd100'"),
    ({"action": ge.gym.JointTargets("dd100", "velocities", ["wheel"])}, "/dd100 has no joint 'wheel'"),
    (
        {"action": ge.gym.JointTargets("dd100", "positions")},
        "without a drive for position targets: front_left_wheel_joint",
    ),
    (
        {"action": ge.gym.JointTargets("dd100", "efforts", ["front_left_wheel_joint"])},
        "dd100: joint front_left_wheel_joint has no limits of efforts\n  give low= and high=",
    ),
    (
        {"action": ge.gym.JointTargets("dd100", "velocities", low=[0.0] * 3)},
        "velocities of dd100: low, high: expected one number, or numbers of shape (2,)",
    ),
    ({"observation": ge.gym.Observation("/dd100_0000/odo")}, "no graph uses topic '/dd100_0000/odo'\n  did you mean"),
    (
        {"observation": ge.gym.Observation(f"{ODOM}.pose.poze")},
        f"{ODOM}.pose.poze: no field 'poze'\n  did you mean 'pose'",
    ),
    ({"observation": ge.gym.Observation(ODOM)}, f"{ODOM}.header.frame_id: expected numbers, got 'odom'"),
    ({"observation": ge.gym.Observation("dd100.sensors.lidar")}, "no sensor 'lidar'\n  did you mean 'sim_lidar'"),
    ({"observation": ge.gym.Observation("dd100.sensors.sim_lidar.range")}, "no field 'range'\n  did you mean 'ranges'"),
    ({"observation": ge.gym.Observation("ComputeOdom.positon")}, "did you mean 'position'"),
    (
        {"observation": ge.gym.Observation("ComputeOdom.position", low=2.0, high=1.0)},
        "expected low below high, got 2.0",
    ),
    ({"observation": ge.gym.Observation(CMD_VEL)}, f"{CMD_VEL}: no message within 5 s of simulation after a reset"),
    ({"ticks": 0}, "ticks: expected 1 or more, got 0"),
    ({"render_mode": "human"}, "render_mode: unknown value 'human'; legal: rgb_array"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_a_mistake_is_told_when_the_environment_is_made(make: Make, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ge.GraphError) as caught:
        make(**arguments)
    assert words in str(caught.value)


def test_an_action_or_an_observation_of_another_size_is_refused(make: Make) -> None:
    env = make(observation=ge.gym.Observation(lambda sim: np.zeros(sim.tick), low=-1.0, high=1.0))
    with pytest.raises(ge.UsageError, match=r"each of \['x, m/s', 'turn rate, rad/s'\], got shape \(3,\)"):
        env.step(np.zeros(3, np.float32))
    env.reset(seed=1)
    with pytest.raises(ge.UsageError, match=r"<lambda>: shape \(2,\), at the start \(1,\); it must stay the same"):
        env.step(np.zeros(2, np.float32))


LAZY = """
import sys
import graphengine as ge
ge.gym.BaseVelocity, ge.gym.Observation
assert "gymnasium" not in sys.modules
sys.modules["gymnasium"] = None  # as if it were not installed
try:
    ge.gym.SceneEnv
except ge.UsageError as error:
    print(error)
"""


def test_gymnasium_is_imported_when_it_is_used_and_its_absence_has_a_remedy() -> None:
    done = subprocess.run([sys.executable, "-c", LAZY], capture_output=True, text=True, check=True, timeout=60)
    said, remedy = done.stdout.splitlines()
    assert said == "ge.gym.SceneEnv needs gymnasium"
    assert remedy.strip().startswith("pip install '")
    assert "[gym]'" in remedy
