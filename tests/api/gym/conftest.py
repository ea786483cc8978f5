"""Makes environments of a dd100 on a floor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

import graphengine as ge

CMD_VEL, SCAN, ODOM = "/dd100_0000/cmd_vel", "/dd100_0000/sim_lidar/scan", "/dd100_0000/odom"
POSITION = ge.gym.Observation(f"{ODOM}.pose.pose.position", low=-10.0, high=10.0)
Make = Callable[..., ge.gym.SceneEnv]


@pytest.fixture(scope="module")
def flat() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


def forward(env: ge.gym.SceneEnv) -> float:
    """The position of the robot on the x axis, m."""
    return env.sim.robots["dd100"].pose.position[0]


DRIVE: dict[str, Any] = {"action": ge.gym.BaseVelocity(CMD_VEL), "observation": POSITION, "reward": forward}


@pytest.fixture
def make(flat: ge.Scene) -> Iterator[Make]:
    """Makes an environment of the dd100 on a floor."""
    with ExitStack() as closing:

        def begin(scene: ge.Scene = flat, **arguments: Any) -> ge.gym.SceneEnv:
            env = ge.gym.SceneEnv(scene, **{**DRIVE, **arguments})
            closing.callback(env.close)
            return env

        yield begin
