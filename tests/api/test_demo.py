"""The scene of `graphrun demo`: the robot drives rounds through the warehouse by its lidar and touches nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

import graphengine as ge
from tests.api.demo_drive import ROBOT, Drive
from tests.other_process import in_another_process

SEEDS = (0, 2, 7)  # `python -m tests.bench.demo` drives ten for three minutes each
A_ROUND = 88.0  # s; the rounds of the seeds take up to 81 s


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("demo")


@pytest.fixture
def sim(scene: ge.Scene) -> Iterator[ge.Session]:
    with scene.session() as sim:
        yield sim


@pytest.mark.parametrize("seed", SEEDS)
def test_a_robot_drives_a_round_and_touches_nothing(scene: ge.Scene, seed: int) -> None:
    with scene.session(seed=seed) as sim:
        drive = Drive(sim, seed)
        drive.run(A_ROUND)
    assert drive.contacts == set()
    assert drive.rounds == 1


@pytest.mark.parametrize(("x", "y", "turned"), [(-9.2, 5.0, 0), (-6.6, 3.5, 90)])
def test_a_pallet_that_is_put_in_its_way_is_passed(sim: ge.Session, x: float, y: float, turned: float) -> None:
    drive = Drive(sim)
    drive.run(12.0)
    half = math.radians(turned) / 2.0
    sim.move("pallet_01", (x, y), (0.0, 0.0, math.sin(half), math.cos(half)))
    drive.run(A_ROUND - 12.0)
    assert drive.contacts == set()
    assert drive.rounds == 1


def test_where_a_pallet_leaves_no_way_the_robot_turns_back(sim: ge.Session) -> None:
    drive = Drive(sim)
    drive.run(2.0)
    sim.move("pallet_01", (-10.0, 1.0))
    drive.run(60.0)
    assert drive.contacts == set()
    assert drive.passed == 3  # it has been in the narrow aisle
    assert drive.place[1] > 1.0


def test_a_robot_that_ignores_its_lidar_touches_a_rack(sim: ge.Session) -> None:
    drive = Drive(sim)
    sim.move(ROBOT, (-6.0, 6.0), (0.0, 0.0, 1.0, 0.0))
    sim.set("Turn.values", [0.0, 0.0])
    sim.set("Speed.values", [0.6, 0.6])
    drive.run(5.0)
    assert drive.contacts == {"rack_04"}


def test_a_velocity_on_cmd_vel_takes_over_until_it_ends(sim: ge.Session) -> None:
    drive = Drive(sim)
    backwards = sim.robots[ROBOT].publish("cmd_vel", {"linear": {"x": -0.3}}, every=0.1)
    sim.run(2.0)
    assert sim.robots[ROBOT].velocity.linear[1] < -0.2
    backwards.close()
    sim.run(3.0)
    assert sim.robots[ROBOT].velocity.linear[1] > 0.2
    assert drive.contacts == set()


def recorded(path: Path, seed: int) -> bytes:
    with ge.load("demo").session(seed=seed, record=path) as sim:
        sim.run(5.0)
    return path.read_bytes()


def test_the_same_seed_gives_the_same_bytes_in_another_process_and_another_seed_others(tmp_path: Path) -> None:
    first, other = recorded(tmp_path / "first.mcap", 1), recorded(tmp_path / "other.mcap", 2)
    assert in_another_process(recorded, tmp_path / "again.mcap", 1) == first
    assert first != other
