"""Movers in sessions: poses, rejected commands, reloads, replays, and equal output in another process."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import graphengine as ge
from tests.other_process import ROOT, in_another_process

SCENE = "dd100_hall_workers"
"""The worker walks along y from (-5, 12) at 1.2 m/s."""


def place(sim: ge.Session) -> list[float]:
    return list(map(float, sim.mujoco.data.body("worker").xpos))


def test_a_mover_can_be_read_but_not_moved() -> None:
    with ge.load(SCENE).session() as sim:
        sim.run(2.5)
        assert place(sim) == pytest.approx([-5.0, 9.0, 0.0])
        with pytest.raises(ge.UsageError, match="it is a mover, and its path determines its pose"):
            sim.move("worker", (0.0, 0.0))
        sim.restore(saved := sim.checkpoint())
        sim.run(2.5)
        assert place(sim) == pytest.approx([-5.0, 6.0, 0.0])
        sim.restore(saved)
        assert place(sim) == pytest.approx([-5.0, 9.0, 0.0])
        sim.reset()
        assert place(sim) == [-5.0, 12.0, 0.0]


def test_a_reload_of_another_path_restarts_the_session(tmp_path: Path) -> None:
    text = (ROOT / f"scenes/{SCENE}.yaml").read_text(encoding="utf-8")
    (tmp_path / "hall.yaml").write_text(text, encoding="utf-8")
    with ge.load(tmp_path / "hall.yaml").session() as sim:
        sim.run(1.0)
        (tmp_path / "hall.yaml").write_text(text.replace("speed: 1.2", "speed: 0.6"), encoding="utf-8")
        sim.reload()
        assert sim.time == 0.0
        sim.run(2.5)
        assert place(sim) == pytest.approx([-5.0, 10.5, 0.0])


CROWD = """
movers:
  worker: {shape: person, region: [[2, 2], [12, 8]], speed: 1.1}
  truck: {shape: forklift, path: [[-4, -3], [20, -3]], speed: 1.5, loop: there_and_back}
"""


def recorded(scene: Path, path: Path, seed: int) -> bytes:
    with ge.load(scene).session(seed=seed, record=path) as sim:
        sim.run(1.0)
        end = np.array(place(sim)).tobytes()
    return end + path.read_bytes()


def test_twenty_robots_among_movers_give_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    fleet = (ROOT / "scenes/dd100_fleet.yaml").read_text(encoding="utf-8").replace("count: 10", "count: 20")
    scene = tmp_path / "fleet.yaml"
    scene.write_text(fleet + CROWD, encoding="utf-8")
    first, other = recorded(scene, tmp_path / "first.mcap", 1), recorded(scene, tmp_path / "other.mcap", 2)
    assert in_another_process(recorded, scene, tmp_path / "again.mcap", 1) == first
    assert first != other
