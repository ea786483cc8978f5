"""How far discovery reaches, between processes: ranges, and machines that have no network."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import DiscoveryRange, Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.ros.conftest import StartPeer
from tests.ros.contract import STRING, Inbox, text
from tests.waiting import PATIENCE, eventually

ISOLATED = ["unshare", "--map-root-user", "--net", "sh", "-c"]
"""Runs a command on a machine with no network, as it were."""

IMPORTS = """
import os, subprocess, sys, time
from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
"""
CALL = """
peer = subprocess.Popen([sys.executable, sys.argv[1], "echo"], stdin=subprocess.PIPE)
heard = []
alice = DdsTransport(JoinOptions(Domain.from_environment(os.environ), "alice"))
alice.reader("/pong", "std_msgs/msg/String", QoS(), heard.append)
ping = alice.writer("/ping", "std_msgs/msg/String", QoS())
deadline = time.monotonic() + 60.0
while not heard and time.monotonic() < deadline:
    ping.write(encode(String("hello")))
    time.sleep(0.01)
alice.close()
peer.communicate()
sys.exit(0 if heard else "nobody answered")
"""
JOIN = """
try:
    DdsTransport(JoinOptions(Domain(1, "LOCALHOST"), "alice"))
except TransportError as error:
    print(error)
"""


def isolated(
    preparation: str, program: str, *arguments: str, reach: DiscoveryRange = "LOCALHOST"
) -> subprocess.CompletedProcess[str]:
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(graphengine.__file__).parents[1]),
        "ROS_DOMAIN_ID": "1",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": reach,
    }
    command = [
        *ISOLATED,
        f'{preparation} && exec "$@"',
        "sh",
        sys.executable,
        "-W",
        "error",
        "-c",
        IMPORTS + program,
        *arguments,
    ]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=2 * PATIENCE, check=False)


@pytest.fixture(scope="module")
def can_isolate() -> None:
    if not shutil.which("unshare") or not shutil.which("ip"):
        pytest.skip("needs unshare and ip, of util-linux and iproute2")
    if subprocess.run([*ISOLATED, "ip link set lo up"], capture_output=True, check=False).returncode:
        pytest.skip("namespaces of users are not permitted here")


@pytest.mark.usefixtures("can_isolate")
@pytest.mark.parametrize("reach", ["LOCALHOST", "SUBNET", "SYSTEM_DEFAULT"])
def test_processes_discover_each_other_with_only_a_loopback_interface(reach: DiscoveryRange) -> None:
    peer = str(Path(__file__).with_name("peer.py"))
    done = isolated("ip link set lo up", CALL, peer, reach=reach)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.usefixtures("can_isolate")
def test_without_an_active_interface_joining_fails() -> None:
    done = isolated("true", JOIN)
    assert done.returncode == 0
    first, *remedies = done.stdout.splitlines()
    assert first.startswith("cannot join domain 1, discovery range LOCALHOST")
    assert remedies == ["is a network interface up?", "to run without a network: --transport memory"]


@pytest.fixture(params=["LOCALHOST", "SUBNET"])
def alice(request: pytest.FixtureRequest, domain_id: int) -> Iterator[DdsTransport]:
    transport = DdsTransport(JoinOptions(Domain(domain_id, request.param), "alice"))
    yield transport
    transport.close()


def test_ranges_except_off_discover_peers_on_this_machine(alice: DdsTransport, start_peer: StartPeer) -> None:
    inbox = Inbox()
    alice.reader("/pong", STRING, QoS(), inbox)
    ping = alice.writer("/ping", STRING, QoS())
    start_peer("echo", ROS_AUTOMATIC_DISCOVERY_RANGE="OFF")
    for reach in ("LOCALHOST", "SUBNET"):
        start_peer("echo", ROS_AUTOMATIC_DISCOVERY_RANGE=reach)
    assert eventually(lambda: inbox.texts, lambda: ping.write(text("hello")))
    assert eventually(lambda: len(alice.graph().publishers("/pong")) >= 2)
    assert len(alice.graph().publishers("/pong")) == 2
