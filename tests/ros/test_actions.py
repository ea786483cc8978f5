"""Actions between two nodes of every transport: a graph offers one, and a caller in another node pursues goals."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.messages.actions import ActionServer
from graphengine.messages.goals import ABORTED, CANCELED, SUCCEEDED
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.network import LiveNetwork
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from tests.action_graph import CLIENT, FIBONACCI, GOAL, SERVER
from tests.action_peer import ActionServerPeer
from tests.jobs.harness import ROOT
from tests.ros import needs
from tests.ros.contract import ALL, AnyTransport, Join
from tests.waiting import PATIENCE, eventually

OF_ROS = pytest.param("rclpy", marks=pytest.mark.ros(needs.carried("example_interfaces")))
SLOW = SERVER.replace("duration: 3", "duration: 1000000")


@pytest.fixture(params=ALL)
def kind(request: pytest.FixtureRequest) -> str:
    if "rclpy" in request.param:
        needs.skip_for(needs.carried("example_interfaces"))
    if " to " in request.param:
        needs.skip_for(needs.wheels() and needs.cyclone())  # of wheels, both sides are on embedded DDS
    return str(request.param)


class Run:
    """A session of a graph on a transport; the test runs its ticks."""

    def __init__(self, transport: AnyTransport, folder: Path, text: str) -> None:
        path = folder / "graph.yaml"
        path.write_text(f"format: 1\ngraph: graph\n{text}", "utf-8")
        self.session: SessionCore = build.start(build.load(path), LiveNetwork(lambda _: transport, 0, print))
        self.nodes: dict[str, Any] = {
            instance.id: node
            for run in self.session.graphs
            for instance, node in zip(run.executor.graph.instances, run.executor.nodes, strict=True)
        }

    def until(self, condition: Callable[[], object]) -> None:
        """Run ticks until something holds."""
        assert eventually(condition, lambda: self.session.step(1))


@pytest.fixture
def play(bob: AnyTransport, tmp_path: Path) -> Iterator[Callable[[str], Run]]:
    with contextlib.ExitStack() as closing:

        def play(text: str) -> Run:
            run = Run(bob, tmp_path, text)
            closing.callback(run.session.close)
            return run

        yield play


def calling(transport: AnyTransport) -> ActionCaller:
    """A caller that knows of a server."""
    caller = ActionCaller(transport, "/fibonacci", FIBONACCI)
    assert eventually(lambda: caller.ready)
    return caller


def test_a_goal_succeeds_with_feedback(play: Callable[[str], Run], alice: AnyTransport) -> None:
    run = play(SERVER.replace("duration: 3", "duration: 100"))
    heard: list[Any] = []
    call = calling(alice).send(GOAL(7), heard.append)
    run.until(call.result.done)
    assert call.accepted.result(0) is True
    assert call.result.result(0).status == SUCCEEDED
    assert list(call.result.result(0).result.sequence) == [0, 1, 1]
    assert {tuple(message.sequence) for message in heard} == {(0, 1)}


def test_a_goal_is_cancelled(play: Callable[[str], Run], alice: AnyTransport) -> None:
    run, caller = play(SLOW), calling(alice)
    call = caller.send(GOAL(7))
    run.until(call.accepted.done)
    answer = caller.cancel(call.goal)
    run.until(call.result.done)
    assert [bytes(info.goal_id.uuid) for info in answer.result(PATIENCE).goals_canceling] == [call.goal]
    assert call.result.result(0).status == CANCELED


def test_a_goal_is_preempted_by_the_next(play: Callable[[str], Run], alice: AnyTransport) -> None:
    run, caller = play(SLOW), calling(alice)
    first = caller.send(GOAL(1))
    run.until(first.accepted.done)
    second = caller.send(GOAL(2))
    run.until(first.result.done)
    assert first.result.result(0).status == ABORTED
    run.until(second.accepted.done)
    assert not second.result.done()


def test_a_goal_is_rejected_while_another_is_pursued(play: Callable[[str], Run], alice: AnyTransport) -> None:
    run = play(SLOW.replace("actionName: fibonacci", "actionName: fibonacci, preempts: false"))
    caller = calling(alice)
    calls = [caller.send(GOAL(number)) for number in range(2)]
    run.until(lambda: all(call.accepted.done() for call in calls))
    assert [call.accepted.result(0) for call in calls] == [True, False]


def test_a_goal_ends_when_its_server_closes(play: Callable[[str], Run], alice: AnyTransport) -> None:
    run = play(SLOW)
    call = calling(alice).send(GOAL(7))
    run.until(call.accepted.done)
    (server,) = run.session.services.actions
    assert isinstance(server, ActionServer)
    run.until(lambda: server.active[0].waiting)
    run.session.stop()
    assert eventually(call.result.done)
    assert call.result.result(0).status == ABORTED


def test_a_graph_sends_a_goal(play: Callable[[str], Run], alice: AnyTransport) -> None:
    server = ActionServerPeer(alice, "/fibonacci", FIBONACCI)
    run = play(CLIENT)
    client = run.nodes["Client"]
    run.until(lambda: server.goals)
    assert [message.order for message in server.messages] == [3]
    server.answer_goal()
    run.until(lambda: server.asked)

    def heard() -> bool:
        server.say(server.goals[0], sequence=[0])
        return list(client.feedback__sequence) == [0]

    run.until(heard)
    server.answer_result(SUCCEEDED, sequence=[0, 1])
    run.until(lambda: client.status == "succeeded")
    assert list(client.result__sequence) == [0, 1]


@contextlib.contextmanager
def running(folder: Path, transport: str, domain: int, text: str, *options: str) -> Iterator[subprocess.Popen[bytes]]:
    """A run of a graph in a process of its own."""
    path = folder / "graph.yaml"
    path.write_text(f"format: 1\ngraph: graph\n{text}", "utf-8")
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [
        sys.executable,
        "-m",
        "graphengine.cli",
        "run",
        str(path),
        "--transport",
        transport,
        "--no-control",
        *options,
    ]
    process = subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(PATIENCE)


@pytest.mark.parametrize("kind", ["dds", OF_ROS])
def test_a_run_of_another_process_pursues_goals_and_aborts_them_at_its_end(
    tmp_path: Path, domain_id: int, join: Join, kind: str
) -> None:
    with running(tmp_path, kind, domain_id, SLOW) as process:
        caller, heard = calling(join("alice")), list[Any]()
        first = caller.send(GOAL(1))
        assert first.accepted.result(PATIENCE)
        caller.cancel(first.goal).result(PATIENCE)
        assert first.result.result(PATIENCE).status == CANCELED
        second = caller.send(GOAL(2), heard.append)
        assert second.accepted.result(PATIENCE)
        assert eventually(lambda: len(heard) > 10)  # by then the request for the result has come
        process.terminate()
        assert second.result.result(PATIENCE).status == ABORTED
        assert process.wait(PATIENCE) == 0
