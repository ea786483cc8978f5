"""A scene of robots whose lidars are noisy, for tests of several robots in one session."""

from __future__ import annotations

from pathlib import Path

from graphengine.format.spec import RobotUse
from graphengine.physics.simulation import Simulation
from tests.jobs.harness import Job

ROBOT = """robot: noisy
extends: robots/dd100.yaml
sensors:
  sim_lidar: {type: lidar, profile: microscan3_light, parent: base_link/chassis_link, position: [0, 0, 0.15], noise_std: 0.01}
"""
SCENE = "scene: crowd\nworld: worlds/flat_grid.xml\nsettle: true\nrobots:\n%s"
FIRST = "  one: {use: noisy.yaml, position: [0, 0, 0.025], namespace: one}\n"
OTHERS = "  other: {use: noisy.yaml, count: 9, per_row: 3, spacing: [6, 6], position: [200, 200, 0.025]}\n"
CLOCK = "graphs:\n  clock: {use: graphs/clock.yaml, at: /World/clock}\n"
LATE = RobotUse(use="noisy.yaml", position=(0.0, 5.0, 0.025), namespace="late")


def scene(folder: Path, *robots: str) -> Path:
    """A scene of robots, as `FIRST` and `OTHERS` are, and a clock."""
    (folder / "noisy.yaml").write_text(ROBOT, encoding="utf-8")
    (folder / "scene.yaml").write_text(SCENE % "".join(robots) + CLOCK, encoding="utf-8")
    return folder / "scene.yaml"


def physics(job: Job) -> Simulation:
    """The world of a running scene."""
    world = job.session.services.world
    assert isinstance(world, Simulation)
    return world
