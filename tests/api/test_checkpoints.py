"""Checkpoints and pickled scenes: sessions that go back, and scenes that go elsewhere."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.cli import main
from tests.api.conftest import Start
from tests.api.test_session import FAILING

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat")


def driven(sim: ge.Session, seconds: float) -> list[object]:
    """What odometry says meanwhile."""
    odom = sim.subscribe("/dd100_0000/odom")
    sim.run(seconds)
    said = list(odom.messages)
    odom.close()
    return said


def test_what_is_published_again_and_again_goes_on_as_it_did(scene: ge.Scene) -> None:
    with scene.session() as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.35)
        sim.run(0.5)
        mark = sim.checkpoint()
        first = driven(sim, 1.5)
        assert sim.robots["dd100"].pose.position[0] > 0.5
        sim.restore(mark)
        assert sim.time == pytest.approx(0.5)
        assert str(driven(sim, 1.5)) == str(first)


def test_a_value_that_was_set_goes_back_too(scene: ge.Scene) -> None:
    limit = "DiffController.maxLinearSpeed"
    with scene.session() as sim:
        mark, before = sim.checkpoint(), sim.value(limit)
        sim.set(limit, 0.25)
        sim.step(3)
        sim.restore(mark)
        assert sim.value(limit) == before


def test_a_session_that_failed_goes_on_from_its_checkpoint(start: Start) -> None:
    sim = start(FAILING)
    sim.step()
    mark = sim.checkpoint()
    with pytest.raises(ge.NodeError):
        sim.run(1.0)
    with pytest.raises(ge.StateError):
        sim.step()
    sim.restore(mark)
    assert (sim.tick, sim.value("Fails.count")) == (1, 1)
    sim.step()
    assert sim.state == "paused"


def test_a_checkpoint_of_another_session_is_refused(scene: ge.Scene) -> None:
    with scene.session() as sim, scene.session() as other:
        mark = sim.checkpoint()
        with pytest.raises(ge.UsageError, match="checkpoint_1 is a checkpoint of another session"):
            other.restore(mark)


def test_a_recorded_run_that_went_back_replays_the_same(
    scene: ge.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "back.mcap"
    with scene.session(record=path) as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.2)
        sim.run(0.5)
        mark = sim.checkpoint()
        for turn in (0.3, -0.3):
            sim.set("DiffController.maxLinearSpeed", 0.3 + turn / 2)
            sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}, "angular": {"z": turn}})
            sim.spawn("late", "robots/dd100.yaml", position=(0, 3, 0.025), namespace="late")
            sim.push("late", force=(0, 50, 0), duration=0.1)
            sim.run(0.5)
            sim.restore(mark)
        sim.run(0.2)
    assert main(["replay", str(path)]) == 0
    assert "identical" in capsys.readouterr().out


ELSEWHERE = """
import pickle, sys
scene = pickle.load(sys.stdin.buffer)
with scene.session() as sim:
    sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    sim.run(1.0)
    print(repr(sim.robots["dd100"].pose.position))
"""


def test_two_sessions_of_a_pickled_scene_are_apart() -> None:
    scene = pickle.loads(pickle.dumps(ge.load("dd100_warehouse")))
    with scene.session() as driven, scene.session() as still:
        start = driven.robots["dd100"].pose.position, still.robots["dd100"].pose.position
        driven.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        driven.run(5.0)
        still.run(5.0)
        far, near = (sim.robots["dd100"].pose.position for sim in (driven, still))
    distances = [
        sum((a - b) ** 2 for a, b in zip(*pair, strict=True)) ** 0.5 for pair in zip(start, (far, near), strict=True)
    ]
    assert 2.3 < distances[0] < 2.45
    assert distances[1] < 0.01


def test_a_pickled_scene_runs_the_same_in_another_process(scene: ge.Scene, tmp_path: Path) -> None:
    with scene.session() as sim:
        sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        sim.run(1.0)
        here = sim.robots["dd100"].pose.position
    command, where = [sys.executable, "-c", ELSEWHERE], {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, input=pickle.dumps(scene), capture_output=True, cwd=tmp_path, env=where)
    assert done.stdout.decode().strip() == repr(here), done.stderr.decode()
