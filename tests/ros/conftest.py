"""What the tests of the network share: transports, peers in other processes, and waiting."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias, cast

import pytest

import graphengine
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.ros.domain import Domain
from graphengine.ros.foxglove import open_server
from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
from graphengine.ros.foxglove.foxglove_transport import FoxgloveTransport
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.select import open_transport
from tests import waiting
from tests.ros.contract import ALL, SEEN, AnyTransport, Join, composed

OpenDds: TypeAlias = Callable[..., DdsTransport]
StartPeer: TypeAlias = "Callable[..., subprocess.Popen[bytes]]"

os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(Path(__file__).with_name("fast_dds.xml")))


@pytest.fixture(params=ALL)
def kind(request: pytest.FixtureRequest) -> str:
    """The kind of the transports that `join` opens."""
    return str(request.param)


@pytest.fixture
def foxglove() -> Iterator[FoxgloveServer]:
    """A server without clients, to which clients may publish."""
    server = open_server(("127.0.0.1", 0), "test", DEFINITIONS, publish=True)
    yield server
    server.close()


@pytest.fixture
def definitions() -> Definitions:
    """The message types of the transports that `join` opens."""
    return DEFINITIONS


@pytest.fixture
def join(kind: str, domain_id: int, definitions: Definitions, request: pytest.FixtureRequest) -> Iterator[Join]:
    """Joins a domain, the test's or another, as a node; in memory, all that join one domain are one transport.

    A kind such as `dds to rclpy` means that the node called alice is of the first, and all others are of the second.
    """
    joined: list[AnyTransport] = []
    in_memory: dict[int, MemoryTransport] = {}

    def join(name: str, number: int = domain_id) -> AnyTransport:
        transport: AnyTransport
        if kind == "memory":
            transport = in_memory.setdefault(number, MemoryTransport())
        elif kind == SEEN:
            transport = FoxgloveTransport(
                DdsTransport(JoinOptions(Domain(number, "LOCALHOST"), name)), request.getfixturevalue("foxglove")
            )
        elif kind == "rclpy with dds":
            transport = composed(JoinOptions(Domain(number, "LOCALHOST"), name), "std_msgs", "diagnostic_msgs")
        else:
            side = kind.partition(" to ")[0] if name == "alice" else kind.rpartition(" to ")[2]
            options = JoinOptions(Domain(number, "LOCALHOST"), name, definitions=definitions)
            transport = cast(AnyTransport, open_transport(side, options))
        joined.append(transport)
        return transport

    yield join
    for transport in joined:
        transport.close()


@pytest.fixture
def alice(join: Join) -> AnyTransport:
    return join("alice")


@pytest.fixture
def bob(join: Join) -> AnyTransport:
    return join("bob")


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "LOCALHOST")


@pytest.fixture
def dds(domain: Domain) -> Iterator[OpenDds]:
    """Opens nodes of the DDS transport in the test's domain."""
    opened: list[DdsTransport] = []

    def open_node(name: str, announces: bool = True, **options: Any) -> DdsTransport:
        opened.append(DdsTransport(JoinOptions(domain, name, **options), announces=announces))
        return opened[-1]

    yield open_node
    for transport in opened:
        transport.close()


@pytest.fixture
def start_peer(domain_id: int) -> Iterator[StartPeer]:
    """Starts a process that plays a part of `peer.py` in the test's domain, with other variables of its environment."""
    started: list[subprocess.Popen[bytes]] = []

    def start(part: str, **changes: str) -> subprocess.Popen[bytes]:
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "PYTHONPATH": f"{Path(graphengine.__file__).parents[1]}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
            **changes,
        }
        program = [sys.executable, "-W", "error", str(Path(__file__).with_name("peer.py")), part]
        started.append(subprocess.Popen(program, env=environment, stdin=subprocess.PIPE))
        return started[-1]

    yield start
    for process in started:
        end_peer(process)
    assert {process.returncode for process in started} <= {0, -signal.SIGKILL}


def end_peer(process: subprocess.Popen[bytes]) -> None:
    """Let a peer end by itself, which it does when its input ends."""
    assert process.stdin
    process.stdin.close()
    process.wait(timeout=waiting.PATIENCE)


@pytest.fixture(autouse=True)
def environment_is_left_alone() -> Iterator[None]:
    before = dict(os.environ)
    yield
    changed = {name for name in before | dict(os.environ) if before.get(name) != os.environ.get(name)}
    assert changed <= {"PYTEST_CURRENT_TEST"}
