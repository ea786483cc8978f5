"""What `every:` and `evaluator:` of a graph file look like to those who read a graph."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun
from tests.cli.test_schema import faults

PACED = """graph: paced
nodes:
  Tick: OnPlaybackTick
  Publish: {type: ROS2PublishClock, every: {hz: 10}}
  Third: {type: ROS2PublishClock, every: {ticks: 3}, inputs: {topicName: third}}
  First: {type: ROS2PublishClock, every: once, inputs: {topicName: first}}
connections:
  - Tick.tick -> Publish.execIn
  - Tick.tick -> Third.execIn
  - Tick.tick -> First.execIn
"""


@pytest.fixture
def paced(project: Path) -> str:
    (project / "paced.yaml").write_text(PACED, encoding="utf-8")
    return "paced.yaml"


def test_show_prints_the_rate_of_a_node_instead_of_gates(graphrun: Graphrun, paced: str) -> None:
    assert graphrun("show", paced).lines == [
        "paced  at /World/paced, every tick",
        "  Tick: omni.graph.action.OnPlaybackTick",
        "  Publish: isaacsim.ros2.bridge.ROS2PublishClock, every 10 Hz",
        "  Third: isaacsim.ros2.bridge.ROS2PublishClock, every 3 ticks",
        '    topicName = "third"',
        "  First: isaacsim.ros2.bridge.ROS2PublishClock, once",
        '    topicName = "first"',
        "  Tick.tick -> Publish.execIn",
        "  Tick.tick -> Third.execIn",
        "  Tick.tick -> First.execIn",
    ]


def test_a_schedule_has_the_gates(graphrun: Graphrun, paced: str) -> None:
    lines = graphrun("show", paced, "--schedule").lines
    assert "    Publish.every                gate    every 10 Hz, when Tick.tick fires" in lines
    assert "    Publish                      action  when Publish.every.execOut fires" in lines


def test_topics_lists_the_rate_behind_a_gate(graphrun: Graphrun, paced: str) -> None:
    lines = graphrun("topics", paced).lines[1:]
    assert {line.split()[0]: line.split("Clock")[1].split("reliable")[0].strip() for line in lines} == {
        "/clock": "10 Hz",
        "/third": "20 Hz",
        "/first": "on event",
    }


def test_show_marks_push_graphs(graphrun: Graphrun, project: Path) -> None:
    (project / "push.yaml").write_text("graph: push\nevaluator: push\nnodes: {Publish: ROS2PublishClock}\n", "utf-8")
    assert graphrun("show", "push.yaml").lines[0] == "push  at /World/push, every tick, all nodes"
    assert "60 Hz" in graphrun("topics", "push.yaml").lines[1]


@pytest.mark.parametrize("every", ["once", {"hz": 10}, {"hz": 0.5}, {"ticks": 3}, {"hz": "$(rate)"}])
def test_the_schema_accepts_a_legal_rate(every: object) -> None:
    assert faults("graph", {"graph": "g", "nodes": {"A": {"type": "OnPlaybackTick", "every": every}}}) == []


@pytest.mark.parametrize("every", ["twice", 10, {"hz": 0}, {"ticks": 0}, {"ticks": 1.5}, {"rate": 1}])
def test_the_schema_refuses_an_illegal_rate(every: object) -> None:
    assert faults("graph", {"graph": "g", "nodes": {"A": {"type": "OnPlaybackTick", "every": every}}})
