"""A session goes back to a checkpoint, and the same commands lead to the same bytes again."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from graphengine.format.errors import PhysicsError, UsageError
from tests.jobs.harness import Job

TICKS = 200
ROBOT = "robots/dd100.yaml"
Step = Callable[[Job], object]


def command(kind: str, /, **arguments: Any) -> Step:
    return lambda job: job.ask(kind, **arguments)


def say(v: float, w: float, job: Job) -> None:
    job.say("/dd100_0000/cmd_vel", v, w)


def fall(gravity: tuple[float, float, float], job: Job) -> None:
    job.session.services.world.set_gravity(gravity)


def script(chance: random.Random, ticks: int, *, spawned: bool) -> list[list[Step]]:
    """For each tick what is asked for before it."""
    steps: list[list[Step]] = [[] for _ in range(ticks)]
    here = spawned
    for tick in sorted(chance.sample(range(ticks), 14)):
        drive = partial(say, chance.uniform(-1, 1), chance.uniform(-2, 2))
        force = [chance.uniform(-200, 200) for _ in range(3)]
        place = [chance.uniform(-3, 3), chance.uniform(-3, 3)]
        gravity = (0.0, 0.0, chance.uniform(-12, -6))
        kinds: list[Step] = [
            *[drive] * 3,
            command("push", entity="dd100", force=force, duration=chance.uniform(0.01, 0.5)),
            command("move", entity="dd100", position=place, linear=[chance.uniform(-1, 1), 0.0, 0.0], force=True),
            command("press", keys=["W"]),
            command("release", keys=["W"]),
            partial(fall, gravity),
            command("reset", scope=["state"]),
        ]
        if here:
            kinds += [command("delete", name="late")] * 3
        else:
            use = {"use": ROBOT, "position": [chance.uniform(2, 4), 3.0, 0.025], "namespace": "late"}
            kinds += [command("spawn", name="late", use=use, force=True)] * 3
        chosen = chance.choice(kinds)
        here ^= chosen in kinds[9:]
        steps[tick].append(chosen)
    return steps


def play(job: Job, steps: list[list[Step]]) -> list[tuple[str, str, bytes]]:
    """What is sent meanwhile, up to where the robot was thrown away."""
    before = len(job.recorder.stream)
    for asked in steps:
        for ask in asked:
            ask(job)
        job.session.step()
    return job.recorder.stream[before:]


@pytest.mark.parametrize("seed", range(20))
def test_what_follows_a_checkpoint_is_the_same_again(seed: int) -> None:
    chance = random.Random(seed)
    with Job("dd100_flat", seed=seed, rays="mujoco" if seed % 2 else "auto") as job:
        play(job, script(chance, chance.randrange(20, 60), spawned=False))
        there = "late" in job.session.roster.spawned
        kept = job.session.checkpoint()
        steps = script(chance, TICKS, spawned=there)
        first = play(job, steps)
        play(job, script(chance, 30, spawned="late" in job.session.roster.spawned))
        job.session.restore(kept)
        assert ("late" in job.session.roster.spawned) == there
        assert play(job, steps) == first
        job.session.restore(kept)
        assert play(job, steps) == first


@pytest.mark.parametrize("name", ["dd100_warehouse", "dd100_fleet", "tutorial/simple_warehouse", "tutorial/navigation"])
def test_each_scene_that_ships_goes_on_as_it_did(name: str) -> None:
    with Job(name) as job:
        job.run(0.5)
        kept = job.session.checkpoint()
        first = play(job, [[]] * 40)
        job.session.restore(kept)
        assert play(job, [[]] * 40) == first
        assert len(first) > 40


def test_a_checkpoint_that_is_not_there_names_those_that_are() -> None:
    with Job("dd100_flat") as job:
        command("checkpoint", name="before")(job)
        command("restore", name="before")(job)
        with pytest.raises(UsageError, match="no checkpoint 'befor'\n  did you mean 'before'"):
            command("restore", name="befor")(job)


def test_a_session_that_failed_goes_on_from_a_checkpoint() -> None:
    with Job("dd100_flat") as job:
        job.run(0.2)
        kept = job.session.checkpoint()
        first = play(job, [[]] * 20)
        job.session.services.world.set_gravity((1e12, 0.0, 1e12))
        with pytest.raises(PhysicsError):
            job.run(2.0)
        job.session.restore(kept)
        assert play(job, [[]] * 20) == first


def test_of_many_checkpoints_the_one_that_was_not_used_for_longest_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.runtime.session_core.MAX_HELD", 2)
    with Job("dd100_flat") as job:
        for name in ("a", "b"):
            command("checkpoint", name=name)(job)
        command("restore", name="a")(job)
        command("checkpoint", name="c")(job)
        assert list(job.session.held) == ["a", "c"]
