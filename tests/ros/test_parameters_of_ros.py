"""`ros2 param` of the sourced ROS sets the parameters of a run, and `graphrun param` prints the same."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

from tests.parameter_scene import LIMIT, NODE, NODES, write_scene
from tests.ros import needs
from tests.waiting import PATIENCE, eventually

pytestmark = pytest.mark.ros(needs.ros2cli())

GRAPHRUN = (sys.executable, "-m", "graphengine.cli")
TRIES = 5
"""Calls of a program that does not find the node, as ros2cli gives up after the time for discovery."""
Ask = Callable[..., str]


@pytest.fixture(params=[pytest.param("dds", marks=pytest.mark.ros(needs.cyclone())), "rclpy"])
def transport(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def ask(tmp_path: Path, domain_id: int, transport: str) -> Iterator[Ask]:
    """`param` of ros2 or graphrun, beside a run; the standard output."""
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    run = (*GRAPHRUN, "run", str(write_scene(tmp_path)), "--transport", transport, "--rays", "mujoco", "--quiet")

    def printed(program: str, *arguments: str) -> str:
        command = ["ros2"] if program == "ros2" else [*GRAPHRUN]
        more = ["--no-daemon", "--spin-time", "2"] + (["--transport", transport] if program != "ros2" else [])
        call = [*command, *arguments, *more]
        for _ in range(TRIES):
            done = subprocess.run(call, env=env, capture_output=True, text=True, timeout=PATIENCE, check=False)
            if done.returncode == 0:
                break
        return done.stdout

    with subprocess.Popen(run, env=env) as process:
        try:
            assert eventually(lambda: set(NODES) <= set(printed("ros2", "node", "list").split()))
            yield printed
        finally:
            process.terminate()


def test_ros2_param_lists_gets_sets_describes_dumps_and_loads(ask: Ask, tmp_path: Path) -> None:
    for arguments in (("list", NODE), ("list", NODE, "--param-type"), ("get", NODE, LIMIT), ("describe", NODE, LIMIT)):
        assert ask("ros2", "param", *arguments) == ask("graphrun", "param", *arguments) != ""
    dumped = ask("ros2", "param", "dump", NODE)
    assert dumped == ask("graphrun", "param", "dump", NODE)
    assert yaml.safe_load(dumped)[NODE]["ros__parameters"]["drive"]["Control"]["maxLinearSpeed"] == 0.0
    assert ask("ros2", "param", "set", NODE, LIMIT, "1e-5") == "Set parameter successful\n"
    assert ask("ros2", "param", "get", NODE, LIMIT) == "Double value is: 1e-05\n"
    assert ask("ros2", "param", "set", NODE, LIMIT, "fast") == ""
    (tmp_path / "dump.yaml").write_text(dumped, encoding="utf-8")
    loaded = ask("ros2", "param", "load", NODE, str(tmp_path / "dump.yaml")).splitlines()
    assert loaded
    assert all(line.endswith(" successful") for line in loaded)
    assert ask("ros2", "param", "get", NODE, LIMIT) == "Double value is: 0.0\n"
    assert ask("ros2", "param", "set", NODES[0], "real_time_factor", "0.5") == "Set parameter successful\n"
    assert ask("graphrun", "param", "get", NODES[0], "real_time_factor", "--hide-type") == "0.5\n"
