"""Robots whose prims are not `/NAME`: what is addressed by path follows, what is addressed by name stays."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from graphengine.compiler.graph import Graph
from graphengine.format.diagnostics import CheckError
from graphengine.scene import build
from tests.jobs.crowd import FIRST, LATE, physics, scene
from tests.jobs.harness import Job

PLACED = FIRST.replace("use: noisy.yaml", "use: noisy.yaml, at: /World/robots/first")
SECOND = "  two: {use: noisy.yaml, position: [0, 3, 0.025], namespace: two, at: /World/robots/second}\n"
SAME = ("/one/odom", "/one/tf", "/one/tf_static", "/one/platform/joint_states")


def sent(path: Path, overrides: dict[str, float] | None = None) -> tuple[dict[str, list[bytes]], Sequence[Graph]]:
    """What a drive of the first robot sends, by topic, and the graphs."""
    with Job(path, overrides) as job:
        job.drive("/one/cmd_vel", 0.5, 0.3, 1.0)
        return {topic: job.transport.raw(topic) for topic in job.types()}, job.scene.planned


def test_a_robot_below_world_sends_the_same_messages_as_elsewhere(tmp_path: Path) -> None:
    (plain, _), (placed, graphs) = sent(scene(tmp_path, FIRST)), sent(scene(tmp_path, PLACED))
    assert list(plain) == list(placed)
    assert {topic: placed[topic] for topic in SAME} == {topic: plain[topic] for topic in SAME}
    (drive,) = [graph for graph in graphs if graph.name == "one/cmd_vel"]
    assert drive.prim_path == "/World/robots/first/Geometry/base_link/chassis_link/cmd_vel"


def test_values_are_set_by_the_name_of_the_robot(tmp_path: Path) -> None:
    slow, _ = sent(scene(tmp_path, PLACED, SECOND), {"one/cmd_vel/DiffController.maxLinearSpeed": 0.1})
    fast, _ = sent(scene(tmp_path, PLACED, SECOND), {"two/cmd_vel/DiffController.maxLinearSpeed": 0.1})
    assert slow["/one/odom"] != fast["/one/odom"]


def test_robots_below_one_prim_move_by_themselves(tmp_path: Path) -> None:
    with Job(scene(tmp_path, PLACED, SECOND)) as job:
        before = physics(job).entities.state("two").position
        job.drive("/one/cmd_vel", 0.5, 0.0, 1.0)
        assert physics(job).entities.state("one").position[0] > 0.3
        assert physics(job).entities.state("two").position == pytest.approx(before, abs=1e-3)
        assert [(one.name, one.prim_path) for one in physics(job).entities.all()] == [
            ("one", "/World/robots/first"),
            ("two", "/World/robots/second"),
        ]


def test_a_removed_robot_leaves_its_path_free(tmp_path: Path) -> None:
    late = LATE.model_copy(update={"at": "/World/robots/late"})
    with Job(scene(tmp_path, PLACED)) as job:
        for name in ("late", "later"):
            job.spawn(name, late)
            job.run(0.1)
            assert job.session.roster.spawned == [name]
            job.remove(name)
            assert "/World/robots/late" not in physics(job).stage
        assert len(job.heard("/late/odom")) == 12


@pytest.mark.parametrize(
    ("name", "at", "words"),
    [
        ("one", "/World/late", "'one' is taken"),
        ("late", "/World/robots/first", "is taken: /World/robots/first is a robot"),
        ("late", "/World/robots/first/chassis_link/late", "chassis_link is a link"),
        ("late", "/World/robots", "/World/robots is a scope"),
    ],
)
def test_a_path_that_is_taken_is_refused(tmp_path: Path, name: str, at: str, words: str) -> None:
    with Job(scene(tmp_path, PLACED)) as job:
        prims = [prim.path for prim in physics(job).stage.prims()]
        with pytest.raises(CheckError, match=words):
            job.spawn(name, LATE.model_copy(update={"at": at}))
        assert [prim.path for prim in physics(job).stage.prims()] == prims


@pytest.mark.parametrize(
    ("robots", "words"),
    [
        ((FIRST.replace("use:", "at: World/a, use:"),), "'World/a' is not a legal path for a robot's prim"),
        ((FIRST.replace("use:", "at: /World, use:"),), "cannot be named 'World'"),
        ((PLACED, SECOND.replace("/second", "/first")), "/World/robots/first is a robot"),
        ((PLACED, SECOND.replace("/second", "/first/second")), "/World/robots/first is a robot"),
        ((PLACED, SECOND.replace("/robots/second", "/robots")), "/World/robots is a scope"),
        ((SECOND.replace("/World/robots/second", "/one"), FIRST), "/one is a robot"),
    ],
)
def test_the_mistake_is_reported_at_the_line_of_the_scene(tmp_path: Path, robots: tuple[str, ...], words: str) -> None:
    assembly = build.load(scene(tmp_path, *robots))
    (finding,) = assembly.findings.errors
    assert words in finding.message
    assert finding.span is not None
    assert finding.span.line == 4 + len(robots)


def test_robots_of_a_fleet_have_paths_with_numbers(tmp_path: Path) -> None:
    fleet = "  one: {use: noisy.yaml, at: /World/dingo, count: 2, spacing: [2, 2], position: [0, 0, 0.025]}\n"
    with Job(scene(tmp_path, fleet)) as job:
        found = {one.name: one.prim_path for one in physics(job).entities.all()}
    assert found == {"one_0000": "/World/dingo_0000", "one_0001": "/World/dingo_0001"}


FLAT = """graph: flat
nodes:
  Tick: OnPlaybackTick
  Odometry: {type: ComputeOdometry, inputs: {chassisPrim: /World/robots/first/chassis_link}}
  Publish: {type: ROS2PublishOdometry, inputs: {topicName: flat}}
connections:
  - Tick.tick -> Odometry.execIn
  - Odometry.execOut -> Publish.execIn
  - Odometry.position -> Publish.position
"""


def test_a_link_that_is_addressed_directly_below_its_robot_is_noted(tmp_path: Path) -> None:
    path = scene(tmp_path, PLACED)
    path.write_text(path.read_text("utf-8") + "  flat: {use: flat.yaml}\n", "utf-8")
    (tmp_path / "flat.yaml").write_text(FLAT, "utf-8")
    with Job(path) as job:
        notes = [(str(one.span), one.message) for one in job.scene.findings.items if one.code == "N105"]
        job.run(0.1)
        assert len(job.heard("/flat")) == 6
    place = f"{tmp_path / 'flat.yaml'}:4:59"
    words = "the path omits links; the full path within the robot is Geometry/base_link/chassis_link"
    assert notes == [(place, words)]


def test_a_robot_below_world_that_a_graph_commands_is_not_idle(tmp_path: Path) -> None:
    assembly = build.load(scene(tmp_path, PLACED))
    assert [found for found in assembly.findings.items if found.code == "W208"] == []
