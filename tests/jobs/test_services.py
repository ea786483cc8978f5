"""Services between processes: a graph that answers others, and a graph that asks them."""

from __future__ import annotations

import os
import subprocess
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import live
from tests.ros import needs
from tests.service_graph import ANSWER, ASK, CLIENT, SERVER, SET_BOOL, extended
from tests.waiting import PATIENCE, eventually

LIGHT = f"graph: light\n{SERVER}"
ONCE = "  Once: OgnIsaacRunOneSimulationFrame\n"
CALLING = f"graph: calling\n{CLIENT.replace('Tick.tick -> Client', 'Once.step -> Client')}"
CALLING = extended(CALLING, ONCE, "Tick.tick -> Once.execIn")


class Surroundings:
    """A domain of its own, and graphs in files."""

    def __init__(self, number: int, folder: Path) -> None:
        self.number = number
        self.variables = {"ROS_DOMAIN_ID": str(self.number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        self.domain = Domain(self.number, "LOCALHOST")
        self._folder = folder

    def graph(self, text: str) -> str:
        path = self._folder / "graph.yaml"
        path.write_text(text, "utf-8")
        return str(path)


@pytest.fixture
def around(domain_id: int, tmp_path: Path) -> Surroundings:
    return Surroundings(domain_id, tmp_path)


def test_a_graph_answers_another_process(around: Surroundings) -> None:
    answers: list[tuple[int, bool, str]] = []

    def keep(number: int, data: bytes) -> None:
        answer = messages.decode(data, f"{SET_BOOL}_Response")
        answers.append((number, answer.success, answer.message))

    with live("run", around.graph(LIGHT), "--transport", "dds", env=around.variables) as running:
        transport = DdsTransport(JoinOptions(around.domain, "peer"))
        try:
            client = transport.client("/light", SET_BOOL, QoS(), keep)
            assert eventually(lambda: client.ready), running.said
            for data in (True, False, True):
                client.call(messages.encode(ASK(data)))
            assert eventually(lambda: len(answers) == 3), answers
        finally:
            transport.close()
    assert answers == [(1, True, "done"), (2, False, "done"), (3, True, "done")]


def test_a_graph_asks_a_server_that_comes_later(around: Surroundings) -> None:
    asked: list[bool] = []
    said: list[str] = []
    transport = DdsTransport(JoinOptions(around.domain, "peer"))
    made = threading.Event()

    def respond(request_id: bytes, data: bytes) -> None:
        asked.append(messages.decode(data, f"{SET_BOOL}_Request").data)
        assert made.wait(PATIENCE)  # the request may be there before the server is handed out
        server.answer(request_id, messages.encode(ANSWER(True, "it is on")))

    def hear(data: bytes) -> None:
        said.append(messages.decode(data, "std_msgs/msg/String").data)

    try:
        transport.reader("/said", "std_msgs/msg/String", QoS(), hear)
        with live("run", around.graph(CALLING), "--transport", "dds", env=around.variables) as running:
            assert running.hear(lambda text: " Hz, " in text), running.said
            server = transport.server("/light", SET_BOOL, QoS(), respond)
            made.set()
            assert eventually(lambda: said), running.said
    finally:
        transport.close()
    assert (asked, said) == ([True], ["it is on"])


@pytest.mark.ros(needs.ros2cli(), needs.cyclone())
def test_ros2_service_call_is_answered(around: Surroundings) -> None:
    command = ["ros2", "service", "call", "/light", SET_BOOL, "{data: true}"]
    with live("run", around.graph(LIGHT), "--transport", "dds", env=around.variables) as running:
        assert running.hear(lambda text: " Hz, " in text), running.said
        variables = {**os.environ, **around.variables}
        called = subprocess.run(
            command, env=variables, capture_output=True, text=True, timeout=PATIENCE * 2, check=False
        )
    assert called.returncode == 0, called.stderr
    assert "SetBool_Response(success=True, message='done')" in called.stdout


@pytest.mark.ros
@pytest.mark.parametrize("transport", ["rclpy", pytest.param("dds", marks=pytest.mark.ros(needs.cyclone()))])
def test_a_graph_asks_a_server_of_rclpy(around: Surroundings, transport: str) -> None:
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    string, set_bool = import_module("std_msgs.msg").String, import_module("std_srvs.srv").SetBool
    asked: list[bool] = []
    said: list[str] = []

    def respond(request: Any, response: Any) -> Any:
        asked.append(request.data)
        response.success, response.message = True, "it is on"
        return response

    context = rclpy.Context()
    rclpy.init(context=context, domain_id=around.number)
    executor = SingleThreadedExecutor(context=context)
    node = rclpy.create_node("peer", context=context)
    try:
        node.create_service(set_bool, "light", respond)
        node.create_subscription(string, "said", lambda message: said.append(message.data), 10)
        executor.add_node(node)
        ros = {name: os.environ[name] for name in ("PYTHONPATH", "RMW_IMPLEMENTATION") if name in os.environ}
        with live("run", around.graph(CALLING), "--transport", transport, env=around.variables | ros) as running:
            assert running.hear(lambda text: " Hz, " in text), running.said
            assert eventually(lambda: said, lambda: executor.spin_once(0.05)), running.said
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    assert (asked, said) == ([True], ["it is on"])
