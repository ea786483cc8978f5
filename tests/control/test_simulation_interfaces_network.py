"""A run of its own process, controlled over a network from this one."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.ros.dds import DdsTransport
from graphengine.ros.domain import Domain
from graphengine.ros.rcl import RclTransport
from tests.control.harness import PATIENCE
from tests.control.simulators import CRATE, WORLD, Client
from tests.control.test_simulate_steps import ACTION, HIDDEN, identity
from tests.jobs.harness import ROOT
from tests.world.harness import Project

OK, QUITTING = 1, 3


@contextlib.contextmanager
def running(folder: Path, transport: str, domain: int) -> Iterator[subprocess.Popen[bytes]]:
    project = Project(folder).write("world.xml", WORLD)
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    options = ["--transport", transport, "--simulation-interfaces", "--no-control", "--paused"]
    command = [sys.executable, "-m", "graphengine.cli", "run", str(project.folder / "scene.yaml"), *options]
    process = subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE)
    try:
        yield process
    finally:
        process.kill()
        process.wait(PATIENCE)
        assert process.stderr is not None
        process.stderr.close()


@pytest.fixture
def domain() -> int:
    return 101 + (os.getpid() * 11) % 99


@pytest.mark.parametrize("kind", ["dds", pytest.param("rclpy", marks=pytest.mark.ros)])
def test_a_run_of_another_process_is_controlled(tmp_path: Path, domain: int, kind: str) -> None:
    if kind == "rclpy":
        pytest.importorskip("simulation_interfaces")
    with running(tmp_path, kind, domain) as process:
        there = Domain(domain, "LOCALHOST")
        transport = DdsTransport(there, "client") if kind == "dds" else RclTransport(there, "client")
        client = Client(transport)
        try:
            assert list(client.call("get_entities").entities) == ["bot", "ball", "shelf"]
            spawned = client.call(
                "spawn_entity", name="box", resource_string=CRATE, initial_pose__pose__position__y=5.0
            )
            assert spawned.result.result == OK
            assert client.call("step_simulation", steps=6).result.result == OK
            goal = {"goal_id": identity(uuid.uuid4())}
            assert client.ask(f"{HIDDEN}/send_goal", f"{ACTION}_SendGoal", goal__steps=6, **goal).accepted
            assert client.ask(f"{HIDDEN}/get_result", f"{ACTION}_GetResult", **goal).result.result.result == OK
            state = client.call("get_entity_state", entity="ball").state
            assert state.header.stamp.nanosec == int(0.2 * 1e9)
            assert state.twist.linear.z == pytest.approx(-9.81 * 0.2)
            assert client.call("set_simulation_state", state__state=QUITTING).result.result == OK
        finally:
            transport.close()
        assert process.wait(PATIENCE) == 0
