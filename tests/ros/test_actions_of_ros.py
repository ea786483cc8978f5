"""Actions between graphs and the programs of ROS 2: rclpy's clients and servers, and `ros2 action`."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.goals import ABORTED, CANCELED, SUCCEEDED
from graphengine.ros.action_caller import ActionCaller
from tests.action_graph import SERVER
from tests.jobs.harness import ROOT
from tests.ros import needs, test_actions
from tests.ros.contract import Join
from tests.ros.test_actions import SLOW
from tests.waiting import PATIENCE, eventually

OF_WHEELS = Path(sys.prefix, "share", "test_msgs")
PACKAGE = "test_msgs" if OF_WHEELS.is_dir() and not needs.types("test_msgs") else "example_interfaces"
"""The package that has the action: wheels of PyPI have it among the types of ROS 2's own tests."""
FIBONACCI = f"{PACKAGE}/action/Fibonacci"
KNOWN = DEFINITIONS.extended([OF_WHEELS] if PACKAGE == "test_msgs" else [])
GOAL = KNOWN.message_class(f"{FIBONACCI}_Goal")
pytestmark = pytest.mark.ros(needs.types(PACKAGE))


@contextlib.contextmanager
def running(folder: Path, kind: str, domain: int, text: str) -> Iterator[None]:
    """A run of a graph, with the action of the installed package."""
    options = ["--msg-path", str(OF_WHEELS)] if PACKAGE == "test_msgs" else []
    text = text.replace("messagePackage: example_interfaces", f"messagePackage: {PACKAGE}")
    with test_actions.running(folder, kind, domain, text, *options):
        yield


@pytest.fixture(params=[pytest.param("dds", marks=pytest.mark.ros(needs.cyclone())), "rclpy"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def definitions() -> Definitions:
    return KNOWN


class Program:
    """A process of `rclpy_actions.py`, and what it prints."""

    def __init__(self, part: str, environment: dict[str, str]) -> None:
        command = [sys.executable, str(Path(__file__).with_name("rclpy_actions.py")), part, PACKAGE]
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self._waiting: list[dict[str, Any]] = []
        self._lines: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._reading = threading.Thread(target=self._read)
        self._reading.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.put(json.loads(line))

    def tell(self, line: object) -> None:
        """Write a line to its input."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")

    def hear(self, *keys: str) -> dict[str, Any]:
        """The next line that has these keys; the others wait, as answers of different services come in any order."""
        while not (found := [line for line in self._waiting if line.keys() >= set(keys)]):
            self._waiting.append(self._lines.get(timeout=PATIENCE))
        self._waiting.remove(found[0])
        return found[0]

    def end(self) -> None:
        """Let it end by itself."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        assert self.process.wait(PATIENCE) == 0
        self._reading.join(PATIENCE)
        self.process.stdout.close()


@pytest.fixture
def environment(domain_id: int) -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@contextlib.contextmanager
def program(part: str, environment: dict[str, str]) -> Iterator[Program]:
    started = Program(part, environment)
    try:
        yield started
    finally:
        started.end()


def test_a_client_of_rclpy_pursues_goals_of_a_graph(
    tmp_path: Path, domain_id: int, kind: str, environment: dict[str, str]
) -> None:
    text = SERVER.replace("duration: 3", "duration: 60")
    with running(tmp_path, kind, domain_id, text), program("call", environment) as client:
        client.tell(1)
        assert client.hear("accepted") == {"order": 1, "accepted": True}
        assert client.hear("feedback") == {"order": 1, "feedback": [0, 1]}
        assert client.hear("status") == {"order": 1, "status": SUCCEEDED, "sequence": [0, 1, 1]}
        client.tell(2)
        assert client.hear("accepted")["accepted"]
        client.tell(3)
        assert client.hear("accepted") == {"order": 3, "accepted": True}
        assert client.hear("status") == {"order": 2, "status": ABORTED, "sequence": []}
        client.tell("cancel")
        assert client.hear("cancelling") == {"cancelling": 1}
        assert client.hear("status") == {"order": 3, "status": CANCELED, "sequence": []}


def test_a_client_of_rclpy_is_rejected_while_a_goal_is_pursued(
    tmp_path: Path, domain_id: int, kind: str, environment: dict[str, str]
) -> None:
    text = SLOW.replace("actionName: fibonacci", "actionName: fibonacci, preempts: false")
    with running(tmp_path, kind, domain_id, text), program("call", environment) as client:
        for order, accepted in ((1, True), (2, False)):
            client.tell(order)
            assert client.hear("accepted") == {"order": order, "accepted": accepted}


def test_a_server_of_rclpy_pursues_goals(kind: str, join: Join, environment: dict[str, str]) -> None:
    with program("serve", environment):
        caller, heard = ActionCaller(join("alice"), "/fibonacci", FIBONACCI, KNOWN), list[Any]()
        assert eventually(lambda: caller.ready)
        rejected, aborted, done = caller.send(GOAL(-1)), caller.send(GOAL(0)), caller.send(GOAL(5), heard.append)
        assert not rejected.accepted.result(PATIENCE)
        assert aborted.result.result(PATIENCE).status == ABORTED
        outcome = done.result.result(PATIENCE)
        assert (outcome.status, list(outcome.result.sequence)) == (SUCCEEDED, [0, 1, 1, 2, 3, 5, 8])
        assert eventually(lambda: heard)
        endless = caller.send(GOAL(1000))
        assert endless.accepted.result(PATIENCE)
        assert len(caller.cancel(endless.goal).result(PATIENCE).goals_canceling) == 1
        outcome = endless.result.result(PATIENCE)
        assert (outcome.status, list(outcome.result.sequence)) == (CANCELED, [9])


CALLING = """
nodes:
  Tick: OnPlaybackTick
  Client:
    type: ROS2ActionClient
    inputs: {actionName: fibonacci, messagePackage: example_interfaces, messageName: Fibonacci, "Goal:order": 5}
  Once: {type: Once}
  Say: {type: ROS2Publisher, inputs: {topicName: said, messagePackage: std_msgs, messageName: Int32MultiArray}}
connections:
  - Tick.tick -> Once.execIn
  - Once.once -> Client.execIn
  - Client.onResult -> Say.execIn
  - Client.Result:sequence -> Say.data
"""


def test_a_graph_sends_goals_to_a_server_of_rclpy(
    tmp_path: Path, domain_id: int, kind: str, join: Join, environment: dict[str, str]
) -> None:
    from graphengine.messages.messages import decode
    from graphengine.messages.qos import LATCHED

    heard: list[Any] = []
    message_type = "std_msgs/msg/Int32MultiArray"
    latched = '"{\\"durability\\": \\"transientLocal\\"}"'
    text = CALLING.replace("topicName: said,", f"topicName: said, qosProfile: {latched},")
    alice = join("alice")
    alice.reader("/said", message_type, LATCHED, lambda data: heard.append(decode(data, message_type)))
    with running(tmp_path, kind, domain_id, text):
        assert eventually(lambda: alice.graph().publishers("/said"))  # a run sends nothing that nobody reads
        with program("serve", environment):
            assert eventually(lambda: heard)
    assert list(heard[0].data) == [0, 1, 1, 2, 3, 5, 8]


def ros2(environment: dict[str, str], *arguments: str) -> str:
    return output(["ros2", "action", *arguments], environment)


def graphrun(environment: dict[str, str], kind: str, *arguments: str) -> str:
    return output([sys.executable, "-m", "graphengine.cli", "action", *arguments, "--transport", kind], environment)


def output(command: list[str], environment: dict[str, str]) -> str:
    """What a command prints, without UUIDs of goals."""
    done = subprocess.run(
        command, env=environment, cwd=ROOT, check=False, capture_output=True, text=True, timeout=PATIENCE
    )
    return re.sub(r"ID: [0-9a-f]{32}", "ID", done.stdout)


@pytest.mark.ros(needs.ros2cli())
def test_the_verbs_of_ros2_action_and_graphrun_action_print_the_same(
    tmp_path: Path, domain_id: int, kind: str, environment: dict[str, str]
) -> None:
    text = SERVER.replace("duration: 3", "duration: 60").replace(
        "Tick.tick -> Feedback.execIn", "Server.onGoal -> Feedback.execIn"
    )
    goal = "/fibonacci", FIBONACCI, "{order: 5}"
    sent, shown = [(("send_goal", *goal)), ("send_goal", *goal, "--feedback")], [("list", "-t"), ("list", "-c")]
    with running(tmp_path, kind, domain_id, text):
        for arguments in (*sent, *shown, ("info", "/fibonacci", "-t")):
            ours: list[str] = []

            def same(arguments: tuple[str, ...] = arguments, ours: list[str] = ours) -> bool:
                ours[:] = [graphrun(environment, kind, *arguments), ros2(environment, *arguments)]
                return bool(ours[0]) and ours[0] == ours[1]

            assert eventually(same), ours  # the daemon of ros2 needs some time to know of everything
