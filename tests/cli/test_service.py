"""`graphrun service`: services of a live network, in the form of ros2cli."""

from __future__ import annotations

import contextlib
import io
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import Graphrun, live
from tests.waiting import PATIENCE, eventually

SET_BOOL = "std_srvs/srv/SetBool"


class Light:
    """A server of /light that responds at once."""

    def __init__(self, transport: Transport) -> None:
        self.asked: list[bool] = []
        self._server = transport.server("/light", SET_BOOL, QoS(), self._take)

    def _take(self, request_id: bytes, data: bytes) -> None:
        self.asked.append(decode(data, f"{SET_BOOL}_Request").data)
        response: Any = DEFINITIONS.initial(f"{SET_BOOL}_Response")
        response.success, response.message = True, "done"
        self._server.answer(request_id, encode(response))


@pytest.fixture
def peer(domain_id: int) -> Iterator[DdsTransport]:
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "OFF"), "peer", "/robots"))) as transport:
        yield transport


@pytest.fixture
def light(peer: DdsTransport) -> Light:
    return Light(peer)


@pytest.fixture
def service(graphrun: Graphrun) -> Graphrun:
    """`graphrun service` in this process."""
    return lambda verb, *arguments, **ended: graphrun("service", verb, *arguments, "--transport", "dds", **ended)


def test_list_names_services_of_servers_and_clients(service: Graphrun, peer: DdsTransport, light: Light) -> None:
    peer.client("/ask", SET_BOOL, QoS(), lambda number, data: None)
    assert service("list", code=0, err="").out == "/ask\n/light\n"
    assert service("list", "-t", code=0, err="").out == f"/ask [{SET_BOOL}]\n/light [{SET_BOOL}]\n"
    assert service("list", "-c", code=0, err="").out == "2\n"


def test_list_hides_the_services_of_actions_unless_asked(service: Graphrun, peer: DdsTransport, light: Light) -> None:
    peer.server("/go/_action/cancel_goal", "action_msgs/srv/CancelGoal", QoS(), lambda request_id, data: None)
    assert service("list", code=0).out == "/light\n"
    assert service("list", "--include-hidden-services", code=0).out == "/go/_action/cancel_goal\n/light\n"


def test_an_empty_list_names_the_searched_domain(service: Graphrun, domain_id: int) -> None:
    assert service("list", code=0, out="").err.startswith("no services on domain ")
    assert service("list", "-c", code=0).out == "0\n"


def test_type_prints_the_type_alone(service: Graphrun, light: Light) -> None:
    assert service("type", "/light", code=0, err="").out == f"{SET_BOOL}\n"
    assert service("type", "light", code=0, err="").out == f"{SET_BOOL}\n"


def test_type_of_an_unknown_service_suggests_another(service: Graphrun, light: Light) -> None:
    assert "unknown service '/ligth'\ndid you mean '/light'?" in service("type", "/ligth", code=1, out="").err


def test_call_prints_the_request_and_the_response(service: Graphrun, light: Light) -> None:
    result = service("call", "/light", "std_srvs/SetBool", "{data: true}", code=0, err="")
    assert result.out.removeprefix("waiting for service to become available...\n") == (
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        "response:\nstd_srvs.srv.SetBool_Response(success=True, message='done')\n\n"
    )
    assert light.asked == [True]


def test_call_reads_the_request_from_the_standard_input(
    service: Graphrun, light: Light, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("data: true"))
    service("call", "/light", SET_BOOL, "--stdin", code=0)
    service("call", "/light", SET_BOOL, code=0)
    assert light.asked == [True, False]


def test_call_refuses_an_illegal_request(service: Graphrun, light: Light) -> None:
    assert "did you mean 'data'?" in service("call", "/light", SET_BOOL, "{dato: true}", code=1, out="").err
    assert "did you mean 'SetBool'?" in service("call", "/light", "std_srvs/SetBol", code=1, out="").err
    assert "--rate" in service("call", "/light", SET_BOOL, "-r", "0", code=2, out="").err
    assert light.asked == []


@contextlib.contextmanager
def outside(domain_id: int) -> Iterator[DdsTransport]:
    """A peer that programs on this machine can see."""
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as transport:
        yield transport


def variables(domain_id: int) -> dict[str, str]:
    return {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def test_ctrl_c_ends_repeated_calls(domain_id: int) -> None:
    with outside(domain_id) as peer:
        light = Light(peer)
        call = ("service", "call", "/light", SET_BOOL, "{data: true}", "-r", "50", "--transport", "dds")
        with live(*call, env=variables(domain_id), out=True) as calling:
            assert eventually(lambda: len(light.asked) >= 3)
            assert calling.hear(lambda said: said.count("message='done'") >= 3)
            calling.process.send_signal(signal.SIGINT)
            assert calling.process.wait(PATIENCE) == 0
    assert "Traceback" not in calling.said


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (("/light", "std_srvs/srv/Trigger"), f"/light has the type {SET_BOOL}, not std_srvs/srv/Trigger"),
        (("/ligth", SET_BOOL), "/ligth has no server yet; did you mean '/light'?"),
    ],
)
def test_call_waits_for_a_server_and_prints_the_likely_reason(domain_id: int, asked: tuple[str, str], why: str) -> None:
    with outside(domain_id) as peer:
        Light(peer)
        with live("service", "call", *asked, "--transport", "dds", env=variables(domain_id), out=True) as calling:
            assert calling.hear(lambda said: why in said), calling.said
            calling.process.send_signal(signal.SIGINT)
            assert calling.process.wait(PATIENCE) == 1
    assert calling.said.startswith("waiting for service to become available...\n")
