"""The page of a session: what viewers are told, what they may do, and what a lost or slow page costs."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import re
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

import graphengine as ge
from graphengine.cli import main as graphrun
from graphengine.runtime.commands import parse
from graphengine.runtime.run_status import RunStatus
from graphengine.testing import session
from graphengine.view import viewers
from graphengine.view.live_graphs import short_value
from graphengine.view.page_process import _text
from graphengine.view.page_server import MAX_REQUEST
from tests.view.browser3d import Browser3D
from tests.view.harness import Viewer, viewed

CMD_VEL = "/dd100_0000/cmd_vel"
LIMIT = "DiffController.inputs:maxLinearSpeed"


@pytest.fixture
def sim() -> Iterator[ge.Session]:
    with session("dd100_flat") as made:
        yield made


def test_a_viewer_sees_the_facts_of_the_status_line(sim: ge.Session) -> None:
    sim.subscribe("/dd100_0000/odom")
    facts = viewed(sim, lambda viewer: viewer.until(lambda frame: frame["facts"]["messages"] > 0))["facts"]
    assert set(facts) >= {field.name for field in dataclasses.fields(RunStatus)}
    assert (facts["subscribers"], facts["dropped_values"], facts["recorded_bytes"]) == (1, 0, None)
    assert facts["message_rate"] > 0.0


def test_a_viewer_sees_the_graphs_and_the_time(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.until(lambda frame: frame["facts"]["time"] > 0.2)
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        return viewer.stage, viewer.wait("graph")

    stage, graph = viewed(sim, play)
    assert stage["title"] == "dd100_flat"
    assert [graph["name"] for graph in stage["graphs"]] == [graph.name for graph in sim._runner.session.graphs]
    assert stage["drives"] == {"dd100": CMD_VEL}
    assert [(robot["name"], robot["namespace"]) for robot in stage["robots"]] == [("dd100", "dd100_0000")]
    assert {sensor["kind"] for sensor in stage["robots"][0]["sensors"]} >= {"lidar", "camera", "imu"}
    assert graph["name"] == "dd100/cmd_vel"
    assert all(f'data-node="{name}"' in graph["svg"] for name in graph["nodes"])
    assert graph["nodes"]["DiffController"]["place"].endswith("cmd_vel.yaml:15:3")
    assert re.fullmatch(r"/.*/graphs/dd100/cmd_vel\.yaml:15", graph["nodes"]["DiffController"]["copy"])


def test_live_values_are_those_of_the_session_and_only_of_the_graph_that_is_looked_at(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        return viewer.until(lambda frame: frame["values"].get("dd100/cmd_vel"))

    frame = viewed(sim, play)
    assert list(frame["values"]) == ["dd100/cmd_vel"]
    assert frame["values"]["dd100/cmd_vel"][LIMIT] == sim.value("dd100/cmd_vel/DiffController.maxLinearSpeed")


def test_nodes_tell_how_often_they_ran_and_how_long_that_took(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        frame = viewer.until(lambda frame: frame["nodes"].get("dd100/cmd_vel", {}).get("DiffController", [0])[0])
        return frame["nodes"]["dd100/cmd_vel"]

    nodes = viewed(sim, play)
    ran, _, microseconds, _ = nodes["DiffController"]
    assert ran >= 1
    assert 0.0 < microseconds < 1e5


def test_when_nobody_looks_any_more_nodes_are_not_timed(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> None:
        viewer.ask(ask="look", graph="dd100/cmd_vel")
        viewer.until(lambda frame: frame["nodes"].get("dd100/cmd_vel"))

    (run,) = [run for run in sim._runner.session.graphs if run.name == "dd100/cmd_vel"]
    plain = run.executor._pass
    viewed(sim, play)
    sim.run(10.0, rate=1.0, until=lambda _: run.executor._pass is plain)
    assert run.executor._pass is plain


def test_commands_pause_play_and_set_inputs_and_mistakes_are_told(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        answers = [viewer.command("pause")]
        held = viewer.until(lambda frame: frame["facts"]["state"] == "paused")["facts"]["time"]
        answers.append(viewer.command("set", address="DiffController.maxLinearSpeed", value=0.2))
        answers.append(viewer.command("set", address="DiffController.maxLinearSpeed", value="fast"))
        answers.append(viewer.command("fly"))
        assert viewer.until(lambda frame: True)["facts"]["time"] == held
        answers.append(viewer.command("play"))
        return answers

    paused, set_, wrong, unknown, played = viewed(sim, play)
    assert "error" not in paused | set_ | played
    assert "expected a number" in wrong["error"]
    assert "fly" in unknown["error"]
    assert sim.value("DiffController.maxLinearSpeed") == 0.2


def test_a_result_with_numbers_that_json_does_not_have_reaches_the_viewer() -> None:
    result = {"position": np.array([1.0, np.nan]), "range": (float("inf"), True, None), "place": Path("a")}
    assert json.loads(_text({"answer": {"id": 1, "result": result}}))["answer"]["result"] == {
        "position": [1.0, "nan"],
        "range": ["inf", True, None],
        "place": "a",
    }


def test_a_viewer_drives_and_the_robot_stops_when_nobody_does(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> None:
        begun = viewer.until(lambda frame: True)["facts"]["time"]
        viewer.ask(ask="drive", topic=CMD_VEL, twist=[0.5, 0.0, 0.0])
        viewer.until(lambda frame: frame["facts"]["time"] > begun + 2.5)

    viewed(sim, play)
    moved = sim.robots["dd100"].pose.position[0]
    assert 0.1 < moved < 0.6  # for half a second, and the way to a stand
    assert abs(sim.robots["dd100"].velocity.linear[0]) < 0.01


@pytest.mark.parametrize("topic", ["/elsewhere", "", 7])
def test_only_robots_are_driven(sim: ge.Session, topic: object) -> None:
    def play(viewer: Viewer) -> None:
        viewer.ask(ask="drive", topic=topic, twist=[0.5, 0.0, 0.0])
        viewer.ask(ask="drive", topic=CMD_VEL, twist=[float("inf"), 0.0, 0.0])
        viewer.ask(ask="drive", topic=CMD_VEL, twist="forward")
        viewer.until(lambda frame: frame["facts"]["time"] > 0.5)

    viewed(sim, play)
    assert abs(sim.robots["dd100"].pose.position[0]) < 0.01


@pytest.mark.parametrize(
    "asked",
    [
        {"ask": "look", "graph": [], "viewer": "x"},
        {"ask": "select", "robot": {}},
        {"ask": "topics", "open": True, "topic": 7},
        {"ask": "topics", "open": True, "topic": "/no_such_topic"},
        {"ask": "topics", "open": "yes"},
        {"ask": "look", "viewer": None},
        {"ask": "show", "viewers": "many"},
        {"ask": "command", "command": 7, "viewer": {}},
        {"ask": "command", "command": "push", "arguments": {"entity": "dd100", "force": [float("nan")] * 3}},
        {"ask": "command", "command": "pause", "arguments": [], "id": float("nan")},
        {"ask": "drive", "viewer": []},
        {"ask": {}},
        {"ask": ["gone"]},
        {},
    ],
)
def test_a_hostile_viewer_ends_nothing(sim: ge.Session, asked: dict[str, Any]) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(**asked)
        return viewer.command("state")

    assert viewed(sim, play)["result"]["state"] == "playing"


def test_values_are_shown_short_and_what_is_no_value_by_its_class() -> None:
    class Odd:
        def __str__(self) -> str:
            raise ValueError

    nan = float("nan")
    for value, text in (
        (True, "true"),
        (None, "none"),
        (0.5, 0.5),
        (2**70, 2**70),
        (nan, "nan"),
        ("x" * 500, "x" * 200),
        ((0.5, 1, "a", Odd()), "(0.5, 1, a, Odd)"),
        (np.arange(3.0), "(0, 1, 2)"),
        (np.array([0.45, 2.0], np.float32), "(0.45, 2)"),
        (np.array([1, 2]), "(1, 2)"),
        (np.array([*range(9), nan]), "(10,) 0 to 8"),
        (np.full(9, nan), "(9,) not finite"),
        ((0,) * 9, "(0, 0, 0, 0, 0, 0, 0, 0, …)"),
        (Odd(), "Odd"),
    ):
        assert short_value(value) == text


def test_files_of_the_working_directory_are_no_modules_of_the_page(
    sim: ge.Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("json", "viser", "graphengine"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(1)")
    monkeypatch.chdir(tmp_path)
    assert sim.view().startswith("http://127.0.0.1:")


def test_commands_are_parsed_outside_of_the_thread_of_the_ticks(
    sim: ge.Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    threads: list[threading.Thread] = []

    def parse_here(name: str, arguments: Any) -> Any:
        threads.append(threading.current_thread())
        return parse(name, arguments)

    monkeypatch.setattr(viewers, "parse", parse_here)
    assert viewed(sim, lambda viewer: viewer.command("rate", factor=2)) == {"id": 1, "result": None}
    assert [thread.name for thread in threads] == ["page"]


def test_a_command_that_is_too_long_or_nested_too_deeply_is_refused(sim: ge.Session) -> None:
    deep: Any = []
    for _ in range(800):
        deep = [deep]

    def play(viewer: Viewer) -> Any:
        long = viewer.command("set", address="x", value=["x" * MAX_REQUEST])
        nested = viewer.command("set", address="x", value=deep)
        return long, nested, viewer.command("state")

    long, nested, state = viewed(sim, play)
    assert f"at most {MAX_REQUEST} are accepted" in long["error"]
    assert nested["error"].startswith("set: ")
    assert state["result"]["state"] == "playing"


def test_a_page_for_looking_takes_no_commands(sim: ge.Session) -> None:
    answer = viewed(sim, lambda viewer: viewer.command("pause"), read_only=True)
    assert answer["error"] == "this page is read-only: it cannot send commands"


def test_what_viewers_did_is_recorded_and_replayed(tmp_path: Path) -> None:
    path = tmp_path / "seen.mcap"

    def play(viewer: Viewer) -> None:
        begun = viewer.until(lambda frame: True)["facts"]["time"]
        viewer.ask(ask="drive", topic=CMD_VEL, twist=[0.5, 0.0, 0.5])
        viewer.command("set", address="DiffController.maxLinearSpeed", value=0.3)
        viewer.until(lambda frame: frame["facts"]["time"] > begun + 0.5)

    with session("dd100_flat", record=path) as sim:
        viewed(sim, play)
    assert graphrun(["replay", str(path)]) == 0


def pull(viewer: Viewer) -> None:
    """Pull at the robot in the 3D part for a second."""
    browser = Browser3D(viewer.url)
    with browser.socket:
        begun = viewer.until(lambda frame: True)["facts"]["time"]
        while viewer.frame["facts"]["time"] < begun + 1.0:
            browser.drag("start", (2.0, 2.0, 0.1), (0.0, 0.0, 0.1))
            viewer._read()


def test_a_pull_at_a_robot_in_3d_pushes_it_and_a_replay_repeats_it(tmp_path: Path) -> None:
    path = tmp_path / "pulled.mcap"
    with session("dd100_flat", record=path) as sim:
        sim.run(0.5)
        before = np.array(sim.robots["dd100"].pose.position)
        viewed(sim, pull)
        assert np.linalg.norm(np.array(sim.robots["dd100"].pose.position) - before) > 0.02
    assert graphrun(["replay", str(path)]) == 0


def test_who_may_only_look_pulls_at_nothing(sim: ge.Session) -> None:
    sim.run(0.5)
    before = sim.robots["dd100"].pose
    viewed(sim, pull, read_only=True)
    assert sim.robots["dd100"].pose.position == pytest.approx(before.position, abs=1e-3)


def test_a_killed_page_is_told_once_and_the_run_goes_on_and_can_be_seen_again() -> None:
    said: list[str] = []
    with session("dd100_flat", log=lambda severity, node, text: said.append(text)) as sim:
        first = sim.view()
        assert sim.view() == first
        os.kill(sim._runner.feed.page.process_id, signal.SIGKILL)  # type: ignore[union-attr]
        sim.run(10.0, rate=1.0, until=lambda _: bool(said))
        sim.step(100)
        assert [text.partition("\n")[0] for text in said] == ["the process of the page has ended"]
        assert sim.view() != first
        assert viewed(sim, lambda viewer: viewer.until(lambda frame: True))


def test_a_viewer_that_does_not_read_holds_nothing_up(sim: ge.Session) -> None:
    url = sim.view()
    viewer = Viewer(url)
    viewer.ask(ask="look", graph="dd100/cmd_vel")
    assert sim.run(5.0)
    with contextlib.closing(viewer.socket):
        assert sim.run(1.0, rate=2.0)


@pytest.mark.parametrize("host", ["evil.example", "203.0.113.7", ""])
def test_an_address_that_is_not_this_machine_s_is_an_error(sim: ge.Session, host: str) -> None:
    with pytest.raises(ge.UsageError, match="the page"):
        sim.view(host)


def test_a_port_that_is_taken_is_an_error(sim: ge.Session) -> None:
    port = int(sim.view().partition("/#")[0].rpartition(":")[2])
    with session("dd100_flat") as other, pytest.raises(ge.UsageError, match=f"{port}"):
        other.view(port=port)
