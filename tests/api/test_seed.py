"""A reset may bring another seed: then the session goes on as one that began with it."""

from __future__ import annotations

from pathlib import Path

import pytest

import graphengine as ge
from graphengine.cli import main as graphrun
from tests.recording.harness import NOISY_ROBOT, NOISY_SCENE, put


@pytest.fixture
def noisy(tmp_path: Path) -> ge.Scene:
    """A scene whose lidar is noisy."""
    put(tmp_path / "noisy_robot.yaml", NOISY_ROBOT)
    return ge.load(put(tmp_path / "scene.yaml", NOISY_SCENE))


def ranges(sim: ge.Session) -> list[float]:
    """Distances of the scan after half a second."""
    scan = sim.subscribe("/dd100_0000/sim_lidar/scan", keep=1)
    sim.run(0.5)
    scan.close()
    assert scan.latest is not None
    return [float(distance) for distance in scan.latest.ranges]


def test_after_a_reset_with_a_seed_all_is_as_in_a_session_with_that_seed(noisy: ge.Scene) -> None:
    with noisy.session(seed=7) as fresh, noisy.session() as sim:
        expected, other = ranges(fresh), ranges(sim)
        sim.reset(seed=7)
        assert ranges(sim) == expected != other
        sim.reset()
        assert ranges(sim) == expected


def test_restoring_a_checkpoint_restores_its_seed(noisy: ge.Scene) -> None:
    with noisy.session() as sim:
        mark = sim.checkpoint()
        first = ranges(sim)
        sim.reset(seed=7)
        assert ranges(sim) != first
        sim.restore(mark)
        assert ranges(sim) == first


def test_a_checkpoint_is_restored_with_another_seed(noisy: ge.Scene) -> None:
    with noisy.session(seed=7) as fresh, noisy.session() as sim:
        expected = ranges(fresh)
        mark = sim.checkpoint()
        other = ranges(sim)
        sim.restore(mark, seed=7)
        assert ranges(sim) == expected != other
        sim.restore(mark)
        assert ranges(sim) == other


def test_a_seed_without_a_reset_of_the_time_is_refused(noisy: ge.Scene) -> None:
    with noisy.session() as sim, pytest.raises(ge.UsageError, match="add the scope `time`"):
        sim.reset("state", seed=7)


def test_new_seeds_are_recorded_and_replayed(noisy: ge.Scene, tmp_path: Path) -> None:
    path = tmp_path / "out.mcap"
    with noisy.session(record=path) as sim:
        mark = sim.checkpoint()
        ranges(sim)
        sim.reset(seed=7)
        ranges(sim)
        sim.restore(mark, seed=8)
        ranges(sim)
    assert graphrun(["replay", str(path)]) == 0
