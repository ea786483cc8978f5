"""`graphrun service` and `graphrun node` print what `ros2 service` and `ros2 node` print."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.jobs.harness import ROOT
from tests.ros import needs
from tests.ros.test_actions import running
from tests.service_graph import SERVER
from tests.waiting import PATIENCE, eventually

pytestmark = pytest.mark.ros(needs.ros2cli())

VERBS = [
    ("service", "list"),
    ("service", "list", "-t"),
    ("service", "list", "-c"),
    ("service", "list", "-t", "--include-hidden-services"),
    ("service", "type", "/light"),
    ("service", "call", "/light", "std_srvs/srv/SetBool", "{data: true}"),
    ("node", "list"),
    ("node", "list", "-c"),
    ("node", "info", "/graph"),
    ("node", "info", "/graph", "--include-hidden"),
]


@pytest.fixture(params=[pytest.param("dds", marks=pytest.mark.ros(needs.cyclone())), "rclpy"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def lines(command: list[str], environment: dict[str, str]) -> list[str]:
    """What a command prints, without the line that depends on how soon a server is found."""
    done = subprocess.run(
        command, env=environment, cwd=ROOT, check=False, capture_output=True, text=True, timeout=PATIENCE
    )
    # ros2cli's own node is hidden, but some of its services are not.
    return [line for line in done.stdout.splitlines() if not line.startswith("waiting for") and "_ros2cli" not in line]


@pytest.fixture
def environment(domain_id: int) -> Iterator[dict[str, str]]:
    variables = {**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    yield variables
    lines(["ros2", "daemon", "stop"], variables)


def test_the_verbs_print_the_same(tmp_path: Path, domain_id: int, kind: str, environment: dict[str, str]) -> None:
    with running(tmp_path, kind, domain_id, SERVER):
        for verb in VERBS:
            ours, theirs = [sys.executable, "-m", "graphengine.cli", *verb, "--transport", kind], ["ros2", *verb]
            printed: list[list[str]] = []

            def same(ours: list[str] = ours, theirs: list[str] = theirs, printed: list[list[str]] = printed) -> bool:
                printed[:] = [lines(ours, environment), lines(theirs, environment)]
                return bool(printed[0]) and printed[0] == printed[1]

            assert eventually(same), printed  # the daemon of ros2 needs some time to know of everything
