"""The contents of the page's panes (topics, findings, problems of nodes, robots), and the commands of their controls."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("viser", reason="the extra view is not installed")

import graphengine as ge
from graphengine.cli import main as graphrun
from graphengine.testing import session
from graphengine.view.live_topics import LiveTopics
from tests.api import nodes_for_api
from tests.view.harness import HOSTILE, Viewer, viewed, write_lab

ODOM, TEXT = "/dd100_0000/odom", "/text"
RATIO = "/World/lab/Ratio"


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    return write_lab(tmp_path)


@pytest.fixture
def sim(lab: Path) -> Iterator[ge.Session]:
    with session(lab, log=lambda *message: None) as made:
        yield made


def topic(viewer: Viewer, name: str) -> Any:
    """The newest row of a topic."""
    return next(row for row in viewer.told["topics"] if row["name"] == name)


def test_variables_are_told_with_the_ports_of_their_graph(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="look", graph="lab")
        frame = viewer.until(lambda frame: frame["values"].get("lab", {}).get("variable:elapsed", 0.0) > 0.5)
        return viewer.stage["graphs"][0], frame

    graph, frame = viewed(sim, play)
    assert (graph["name"], graph["robot"], graph["prim"], graph["variables"]) == ("lab", "", "/World/lab", ["elapsed"])
    assert frame["values"]["lab"]["variable:elapsed"] == pytest.approx(frame["facts"]["time"])


def test_dropped_values_are_counted_at_their_node_with_the_last_text(sim: ge.Session) -> None:
    found = viewed(sim, lambda viewer: viewer.wait("problems", lambda told: told.get(RATIO, {}).get("count", 0) > 2))
    assert list(found) == [RATIO]
    assert found[RATIO]["severity"] == "warning"
    assert "b must be other than 0" in found[RATIO]["text"]


FAILING = """graph: g
nodes: {Tick: OnPlaybackTick, Fails: {type: api.Fails, inputs: {at: 60}}}
connections: [Tick.tick -> Fails.execIn]
"""


@pytest.fixture
def failing(tmp_path: Path) -> Path:
    path = tmp_path / "g.yaml"
    path.write_text(FAILING, encoding="utf-8")
    return path


def test_a_fault_of_a_run_that_goes_on_is_counted_at_its_node(failing: Path) -> None:
    with session(failing, modules=[nodes_for_api], keep_going=True, log=lambda *message: None) as sim:
        found = viewed(sim, lambda viewer: viewer.wait("problems", lambda told: told))
    ((path, problem),) = found.items()
    assert path.endswith("/Fails")
    assert (problem["severity"], problem["count"]) == ("error", 1)
    assert "ArithmeticError: as it was told" in problem["text"]


def test_a_page_shows_the_problems_from_before_it_was_opened(failing: Path) -> None:
    with session(failing, modules=[nodes_for_api], keep_going=True, log=lambda *message: None) as sim:
        sim.run(2.0)
        found = viewed(sim, lambda viewer: viewer.wait("problems", lambda told: told))
    assert [path.rpartition("/")[2] for path in found] == ["Fails"]


def test_the_error_that_ends_a_run_is_told_and_so_is_the_end(failing: Path) -> None:
    def play(viewer: Viewer) -> Any:
        failed = viewer.until(lambda frame: frame["facts"]["state"] == "failed")["facts"]["failure"]
        return failed, viewer.wait("problems", lambda told: told), viewer.wait("ended")["error"]

    with session(failing, modules=[nodes_for_api]) as sim:
        url = sim.view()
        with ThreadPoolExecutor(1) as pool:
            played = pool.submit(lambda: play(Viewer(url)))
            with pytest.raises(ge.NodeError):
                sim.run(60.0, rate=1.0)
            sim.close()
            failure, problems, ended = played.result()
    assert "ArithmeticError: as it was told" in failure
    assert failure == ended
    assert [path.rpartition("/")[2] for path in problems] == ["Fails"]


def test_topics_are_measured_while_a_viewer_looks_and_the_newest_message_is_shown(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="topics", open=True, topic="")
        viewer.wait("topics")
        unwanted = topic(viewer, ODOM)
        viewer.ask(ask="topics", open=True, topic=ODOM)
        viewer.wait("topics", lambda _: (topic(viewer, ODOM)["rate"] or 0.0) > 59.0)
        message = viewer.wait("message", lambda told: told["topic"] == ODOM and told["rows"])
        viewer.ask(ask="topics", open=False)
        return unwanted, topic(viewer, ODOM), message

    unwanted, wanted, message = viewed(sim, play)
    assert (unwanted["wanted"], unwanted["subscribers"], unwanted["type"]) == (False, 0, "nav_msgs/msg/Odometry")
    assert (wanted["wanted"], wanted["subscribers"], wanted["publishers"]) == (True, 1, 1)
    assert wanted["rate"] == pytest.approx(60.0)
    assert wanted["bandwidth"] == pytest.approx(60.0 * message["size"])
    rows = {row["path"]: row["text"] for row in message["rows"]}
    assert rows["header.frame_id"] == "odom"
    assert float(rows["header.stamp"].removesuffix(" s")) > 0.0
    sim.run(1.0, rate=2.0)
    publishers = sim._runner.network.publishers
    assert not any(one.wanted for one in publishers if one.claim.qos.durability != "transientLocal")
    assert sim._runner.network.taps == []


def test_after_a_reload_topics_are_subscribed_to_again() -> None:
    running: Any = SimpleNamespace(version=0)
    opened: list[str] = []
    closed: list[str] = []

    def listen(topic: str) -> Any:
        opened.append(topic)
        return SimpleNamespace(close=lambda: closed.append(topic))

    topics = LiveTopics(running, listen)
    topics.watch({"/a"})
    topics.watch({"/a"})
    running.version = 1
    topics.watch({"/a"})
    assert (opened, closed) == (["/a", "/a"], ["/a"])


def test_a_message_holds_what_a_stranger_wrote_as_it_is(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="topics", open=True, topic=TEXT)
        return viewer.wait("message", lambda told: told["rows"])

    assert viewed(sim, play)["rows"] == [
        {"depth": 0, "path": "data", "name": "data", "type": "string", "text": HOSTILE, "plots": False}
    ]


def test_findings_have_a_place_and_come_again_when_they_change(sim: ge.Session, lab: Path) -> None:
    broken = f"{lab}:3:1: error G106: unknown key {HOSTILE}\n  legal: world"

    def play(viewer: Viewer) -> Any:
        first = viewer.wait("findings")
        sim._runner.session.findings = (broken,)
        second = viewer.wait("findings", lambda told: told != first)
        sim._runner.session.findings = ()
        return first, second, viewer.wait("findings", lambda told: told == first)

    first, second, _ = viewed(sim, play)
    (unused,) = [row for row in first if row["severity"] == "warning"]
    assert (unused["code"], unused["message"]) == ("W102", "no executed node reads Idle")
    assert unused["copy"] == f"{lab.with_name('lab.yaml')}:8"
    assert unused["place"].endswith("lab.yaml:8:3")
    assert second == [
        {
            "severity": "error",
            "code": "G106",
            "title": "unknown key",
            "message": f"unknown key {HOSTILE}",
            "help": "  legal: world",
            "place": f"{lab}:3:1",
            "copy": f"{lab}:3",
        },
        *first,
    ]


def test_a_selected_robot_is_followed_with_its_pose(sim: ge.Session) -> None:
    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="select", robot="dd100")
        return viewer.until(lambda frame: frame["robots"])["robots"]

    found = viewed(sim, play)
    assert list(found) == ["dd100"]
    assert found["dd100"]["x"] == pytest.approx(sim.robots["dd100"].pose.position[0], abs=1e-3)
    assert found["dd100"]["heading"] == pytest.approx(0.0, abs=0.1)


def test_robots_are_spawned_and_deleted_a_seed_is_set_and_all_of_it_is_replayed(lab: Path, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    use = {"use": "robots/dd100.yaml", "position": [2.0, 0.0, 0.05], "namespace": "second"}

    def play(viewer: Viewer) -> Any:
        wrong = viewer.command("spawn", name="third", use={"use": "../secret.yaml"})
        assert "error" not in viewer.command("spawn", name="second", use=use)
        spawned = viewer.wait("stage", lambda told: len(told["robots"]) == 2)
        assert "error" not in viewer.command("delete", name="second")
        viewer.wait("stage", lambda told: len(told["robots"]) == 1)
        assert "error" not in viewer.command("reset", seed=7)
        viewer.until(lambda frame: frame["facts"]["seed"] == 7 and frame["facts"]["time"] > 0.2)
        return wrong, spawned["robots"][1]

    with session(lab, record=path, log=lambda *message: None) as sim:
        wrong, robot = viewed(sim, play)
    assert "no file '../secret.yaml'" in wrong["error"]
    assert (robot["name"], robot["namespace"], robot["spawned"]) == ("second", "second", True)
    assert graphrun(["replay", str(path)]) == 0
