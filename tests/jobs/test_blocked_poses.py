"""Robots and objects are not placed into others, unless they are forced."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.devices.entity import EntityState
from graphengine.format.errors import BlockedPoseError
from tests.cli.harness import process
from tests.nodes.harness import write

WORLD = """<mujoco><worldbody><geom name="floor" type="plane" size="20 20 1"/>
<body name="wall" pos="5 0 1"><geom type="box" size=".1 5 1"/></body>
<body name="table" pos="0 5 .25"><geom type="box" size="1 1 .25"/></body>
<body name="crate" pos="0 -3 .25"><freejoint/><geom type="box" size=".25 .25 .25" mass="5"/></body>
</worldbody></mujoco>"""
SCENE = (
    "scene: s\nworld: world.xml\nrobots: {dd100: {use: robots/dd100.yaml, position: [0, 0, 0.02], namespace: first}}\n"
)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    write(tmp_path, {"world.xml": WORLD, "scene.yaml": SCENE})
    return tmp_path / "scene.yaml"


def state(sim: ge.Session, name: str) -> EntityState:
    return sim._runner.session.services.world.entities.state(name)


def place_crate(sim: ge.Session, **how: object) -> None:
    sim.move("crate", **how)  # type: ignore[arg-type]


def spawn(sim: ge.Session, x: float, y: float, z: float = 0.02, *, force: bool = False) -> None:
    sim.spawn("late", "robots/dd100.yaml", position=(x, y, z), namespace="late", force=force)


@pytest.mark.parametrize(
    ("act", "obstacle"),
    [
        (lambda sim: place_crate(sim, position=(4.8, 0, 0.25)), "0.15 m deep in wall"),
        (lambda sim: place_crate(sim, position=(0, 5, 0.7)), "0.05 m deep in table"),
        (lambda sim: place_crate(sim, position=(0.0, 0.0, 0.25)), "m deep in dd100"),
        (
            lambda sim: place_crate(sim, position=(4.6, 0, 0.25), orientation=(0, 0, 0.3826834, 0.9238795)),
            "m deep in wall",
        ),
        (lambda sim: sim.move("dd100", (4.8, 0)), "m deep in wall"),
        (lambda sim: sim.move("wall", (0, -3, 1)), "m deep in crate"),
        (lambda sim: spawn(sim, 0.2, 0.0), "m deep in dd100"),
        (lambda sim: spawn(sim, 4.8, 1.0), "m deep in wall"),
    ],
)
def test_a_pose_within_something_is_refused_with_its_name_and_changes_nothing(
    scene: Path, act: Callable[[ge.Session], None], obstacle: str
) -> None:
    with ge.load(scene).session() as sim, ge.load(scene).session() as other:
        for one in (sim, other):
            one.run(0.2)
        claims = list(sim._runner.session.services.claims)
        with pytest.raises(BlockedPoseError, match=r"would be .*nothing was changed") as error:
            act(sim)
        assert obstacle in str(error.value)
        assert list(sim.robots) == ["dd100"]
        assert sim._runner.session.services.claims == claims
        for one in (sim, other):
            one.run(0.2)
        for name in ("dd100", "crate", "wall"):
            assert state(sim, name) == state(other, name)


@pytest.mark.parametrize(
    "act",
    [
        lambda sim: place_crate(sim, position=(4.6, 0, 0.25)),
        lambda sim: place_crate(sim, position=(0, 5, 0.75)),
        lambda sim: place_crate(sim, position=(2, 2, 0.2)),  # in the floor, which lifts it out
        lambda sim: place_crate(sim, position=(4.8, 0, 0.25), force=True),
        lambda sim: sim.move("wall", (7, 0, 1)),
        lambda sim: spawn(sim, 2.0, 0.0),
        lambda sim: spawn(sim, 2.0, 0.0, -0.02),
        lambda sim: spawn(sim, 0.2, 0.0, force=True),
    ],
)
def test_free_places_supports_and_forced_poses_are_taken(scene: Path, act: Callable[[ge.Session], None]) -> None:
    with ge.load(scene).session() as sim:
        sim.run(0.1)
        act(sim)
        sim.run(0.05)


def test_what_is_within_something_already_gets_a_velocity_and_may_leave(scene: Path) -> None:
    with ge.load(scene).session() as sim:
        place_crate(sim, position=(4.8, 0, 0.25), force=True)
        place_crate(sim, linear=(-1.0, 0.0, 0.0))
        place_crate(sim, position=(4.75, 0, 0.25))
        with pytest.raises(BlockedPoseError):
            place_crate(sim, position=(4.9, 0, 0.25))


def test_a_replay_repeats_forced_commands_and_those_of_recordings_that_know_no_force(
    scene: Path, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    with ge.load(scene).session(record=path) as sim:
        sim.run(0.1)
        with pytest.raises(BlockedPoseError):
            spawn(sim, 0.2, 0.0)
        with pytest.raises(BlockedPoseError):
            place_crate(sim, position=(4.8, 0, 0.25))
        place_crate(sim, position=(4.8, 0, 0.25), force=True)
        spawn(sim, 0.2, 0.0, force=True)
        sim.run(0.5)
    assert b'"force"' not in path.read_bytes()
    assert process("replay", str(path), cwd=tmp_path, code=0).out.startswith("identical")
