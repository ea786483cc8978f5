"""MuJoCo's own objects of a session: what is written to them acts, is not recorded, and goes with a reset."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

import graphengine as ge
from graphengine.cli import main
from tests.api.conftest import Start

TICK, STEP = 1 / 60, 1 / 240  # s


def lift(sim: ge.Session, height: float) -> None:
    """Set the height of the dd100, m, as a user of MuJoCo does."""
    model, data = sim.mujoco.model, sim.mujoco.data
    data.qpos[model.jnt_qposadr[model.body("dd100/base_link").jntadr[0]] + 2] = height
    mujoco.mj_forward(model, data)


def test_values_written_to_mujoco_take_effect_until_a_reset(sim: ge.Session) -> None:
    rest = sim.robots["dd100"].pose
    lift(sim, 5.0)
    assert sim.robots["dd100"].pose.position[2] == 5.0
    sim.step(30)
    fallen = 9.81 * (30 * TICK) * (30 * TICK + STEP) / 2  # semi-implicit Euler: g h² n (n + 1) / 2
    assert 5.0 - sim.robots["dd100"].pose.position[2] == pytest.approx(fallen, rel=1e-3)
    sim.reset()
    assert sim.robots["dd100"].pose == rest


def test_a_spawned_robot_is_in_another_model(sim: ge.Session) -> None:
    model, objects = sim.mujoco.model, sim.mujoco
    sim.spawn("second", "robots/dd100.yaml", position=(0, 2, 0.03), namespace="second")
    assert objects.model is sim.mujoco.model
    assert objects.model is not model
    assert sim.mujoco.data.qpos.size == objects.model.nq == 2 * model.nq


def test_values_written_to_mujoco_are_not_recorded(tmp_path: Path) -> None:
    with ge.load("dd100_flat", rays="mujoco").session(record=tmp_path / "run.mcap") as sim:
        sim.step(3)
        lift(sim, 5.0)
        sim.step(3)
    assert main(["replay", str(tmp_path / "run.mcap")]) == 1


def test_a_graph_without_a_scene_has_none(start: Start) -> None:
    objects = start("nodes: {Tick: OnPlaybackTick}").mujoco
    with pytest.raises(ge.UsageError, match="a graph without a scene has no MuJoCo model"):
        _ = objects.model
