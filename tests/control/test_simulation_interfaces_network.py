"""A run of its own process, controlled over a network from this one."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.select import open_transport
from tests.control.simulators import CRATE, WORLD, Client
from tests.control.test_simulate_steps import ACTION, HIDDEN, identity
from tests.jobs.harness import ROOT
from tests.physics.harness import Project
from tests.ros import needs
from tests.waiting import PATIENCE

OK, QUITTING = 1, 3
RCLPY = pytest.param("rclpy", marks=pytest.mark.ros(needs.carried("simulation_interfaces")))


@contextlib.contextmanager
def running(folder: Path, transport: str, domain: int, *namespace: str) -> Iterator[subprocess.Popen[bytes]]:
    project = Project(folder).write("world.xml", WORLD)
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    options = ["--transport", transport, "--simulation-interfaces", *namespace, "--no-control", "--paused"]
    command = [sys.executable, "-m", "graphengine.cli", "run", str(project.folder / "scene.yaml"), *options]
    process = subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE)
    try:
        yield process
    finally:
        process.kill()
        process.wait(PATIENCE)
        assert process.stderr is not None
        process.stderr.close()


@pytest.mark.parametrize("kind", ["dds", RCLPY])
def test_a_run_of_another_process_is_controlled(tmp_path: Path, domain_id: int, kind: str) -> None:
    with running(tmp_path, kind, domain_id) as process:
        there = Domain(domain_id, "LOCALHOST")
        transport = open_transport(kind, JoinOptions(there, "client"))
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


def entities(client: Client, namespace: str) -> list[str]:
    return list(client.ask(f"{namespace}/get_entities", "simulation_interfaces/srv/GetEntities").entities)


@pytest.mark.parametrize("kind", ["dds", RCLPY])
def test_two_runs_in_one_domain_have_separate_namespaces(tmp_path: Path, domain_id: int, kind: str) -> None:
    with running(tmp_path, kind, domain_id, "/one") as one, running(tmp_path, kind, domain_id, "/two") as two:
        there = Domain(domain_id, "LOCALHOST")
        transport = open_transport(kind, JoinOptions(there, "client"))
        client = Client(transport)
        try:
            assert entities(client, "one") == entities(client, "two") == ["bot", "ball", "shelf"]
            crate = {"name": "box", "resource_string": CRATE, "initial_pose__pose__position__y": 5.0}
            spawned = client.ask("two/spawn_entity", "simulation_interfaces/srv/SpawnEntity", **crate)
            assert spawned.result.result == OK
            assert (len(entities(client, "one")), len(entities(client, "two"))) == (3, 4)
            asked = client.ask(
                "one/scene/get_parameters", "rcl_interfaces/srv/GetParameters", names=["real_time_factor"]
            )
            assert [value.double_value for value in asked.values] == [1.0]
        finally:
            transport.close()
        for run in (one, two):
            run.send_signal(signal.SIGINT)
            _, said = run.communicate(timeout=PATIENCE)
            assert b"either program may answer" not in said


def test_two_runs_with_the_same_services_warn_about_each_other(tmp_path: Path, domain_id: int) -> None:
    with running(tmp_path, "dds", domain_id) as one, running(tmp_path, "dds", domain_id) as two:
        for run in (one, two):
            assert run.stderr is not None
            said = iter(run.stderr.readline, b"")
            assert next(line for line in said if line.startswith(b"warning")) == (
                b"warning: another program also offers services of this run: either program may answer a call\n"
            )
            assert b"/get_simulator_features" in run.stderr.readline()
