"""A robot that is moved, pushed and reset while its graphs run, as a hand in the simulator's window would."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.errors import UnknownEntityError, UsageError
from graphengine.runtime.commands import parse
from tests.jobs.crowd import FIRST, LATE, physics, scene
from tests.jobs.harness import Job, nanoseconds, yaw


def place(job: Job) -> tuple[float, float, float]:
    """Where odometry says that the robot is, m and rad."""
    pose = job.newest("/one/odom").pose.pose
    return pose.position.x, pose.position.y, yaw(pose.orientation)


def true_place(job: Job, name: str = "one") -> tuple[float, float]:
    x, y, _ = physics(job).entities.state(name).position
    return x, y


@pytest.fixture
def job(tmp_path: Path) -> Any:
    with Job(scene(tmp_path, FIRST)) as running:
        running.run(0.5)
        yield running


# Disturbances


def test_the_odometry_of_a_robot_that_is_moved_continues_as_rep_105_demands(job: Job) -> None:
    job.drive("/one/cmd_vel", 0.5, 0.3, 1.0)
    job.drive("/one/cmd_vel", 0.0, 0.0, 1.0)
    before = place(job)
    job.ask("move", entity="one", position=[2.0, -1.0], orientation={"rpy_deg": [0.0, 0.0, 90.0]})
    for _ in range(5):
        job.session.step()
        assert place(job) == pytest.approx(before, abs=2e-3)
    job.drive("/one/cmd_vel", 0.5, 0.0, 1.0)
    x, y, turned = place(job)
    ahead = (x - before[0]) * math.cos(turned) + (y - before[1]) * math.sin(turned)
    assert ahead == pytest.approx(math.hypot(x - before[0], y - before[1]), abs=0.01)
    assert ahead > 0.3
    assert turned == pytest.approx(before[2], abs=0.02)


def test_the_odometry_of_a_robot_that_is_moved_jumps_where_that_is_asked_for(job: Job) -> None:
    job.ask("move", entity="one", position=[2.0, -1.0], orientation={"rpy_deg": [0.0, 0.0, 90.0]}, odometry="jumps")
    job.session.step()
    assert place(job) == pytest.approx((2.0, -1.0, math.pi / 2), abs=2e-3)
    (odom,) = [t for t in job.newest("/one/tf").transforms if t.child_frame_id == "base_link"]
    assert (odom.transform.translation.x, odom.transform.translation.y) == pytest.approx((2.0, -1.0), abs=2e-3)
    assert job.velocity("/one/odom") == pytest.approx((0.0, 0.0), abs=0.05)


def test_a_move_in_a_recording_of_an_older_version_lets_the_odometry_jump_as_it_did(
    job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(type(job.session.inbox), "replays", True)
    parse("move", {"entity": "one", "position": [2.0, -1.0]}).apply(job.session)
    job.session.step()
    assert place(job)[:2] == pytest.approx((2.0, -1.0), abs=2e-3)


def test_clearance_names_what_would_stand_close_at_another_place_and_changes_nothing(job: Job) -> None:
    job.ask("spawn", name="late", use=LATE.model_dump())
    job.run(0.2)
    entities, before = physics(job).entities, true_place(job)
    assert entities.clearance("one", (0.0, 4.7), 0.05) == {"late": 0.0}
    assert entities.clearance("one", (0.0, 3.0), 0.05) == {}
    far = entities.clearance("one", (0.0, 3.0), 2.0)
    assert list(far) == ["late"]
    assert 1.0 < far["late"] < 2.0
    assert true_place(job) == before


def test_a_robot_that_is_moved_drives_on_from_there(job: Job) -> None:
    job.drive("/one/cmd_vel", 0.5, 0.0, 1.0)
    turned = {"rpy_deg": [0.0, 0.0, 180.0]}
    job.ask("move", entity="one", position=[0.0, 3.0], orientation=turned, odometry="jumps")
    job.drive("/one/cmd_vel", 0.5, 0.0, 2.0)
    x, y, _ = place(job)
    assert x < -0.7
    assert y == pytest.approx(3.0, abs=0.05)


def test_a_push_is_seen_in_odometry_and_the_robot_comes_to_rest_after_it(job: Job) -> None:
    before, begun = place(job), job.session.ticks
    job.ask("push", entity="one", force=[0.0, 150.0, 0.0], duration=0.5)
    moving = []
    for _ in range(60):
        job.session.step()
        moving.append(place(job)[1])
    job.run(2.0)
    assert job.session.ticks == begun + 180
    assert moving[29] > before[1] + 0.05
    assert job.velocity("/one/odom") == pytest.approx((0.0, 0.0), abs=0.01)
    assert place(job)[:2] == pytest.approx(true_place(job), abs=1e-6)


def test_an_impulse_is_spread_over_a_tick(job: Job) -> None:
    world = physics(job)
    job.ask("move", entity="one", position=[0.0, 0.0, 5.0])
    before = world.entities.state("one").linear_velocity
    job.ask("push", entity="one", impulse=[0.0, 3.0, 0.0])
    job.session.step()
    after = world.entities.state("one").linear_velocity
    mass = world.model.body_subtreemass[world.model.body(world.stage.find("/one/base_link").body).id]
    assert after[1] - before[1] == pytest.approx(3.0 / mass, rel=0.02)
    job.session.step()
    assert world.entities.state("one").linear_velocity[1] == pytest.approx(after[1], rel=1e-3)


def test_what_is_not_there_is_told(job: Job) -> None:
    with pytest.raises(UnknownEntityError, match="no entity 'onee'\n  did you mean 'one'"):
        job.ask("move", entity="onee", position=[0.0, 0.0])
    with pytest.raises(UnknownEntityError, match="no robot 'tow'"):
        job.ask("delete", name="tow")


def test_what_is_beyond_all_bounds_changes_nothing(job: Job) -> None:
    before = physics(job).entities.state("one")
    with pytest.raises(UsageError, match="legal: at most"):
        job.ask("move", entity="one", position=[1e9, 0.0, 0.0])
    with pytest.raises(UsageError, match="legal: at most"):
        job.ask("push", entity="one", force=[0.0, 0.0, 1e30], duration=1.0)
    assert physics(job).entities.state("one") == before


# Resets


def spawned_and_driven(job: Job) -> None:
    job.ask("spawn", name="late", use=LATE.model_dump())
    for _ in range(10):
        job.say("/late/cmd_vel", 0.5, 0.0)
        job.drive("/one/cmd_vel", 0.5, 0.0, 0.1)


def test_a_reset_of_the_state_puts_robots_back_and_time_goes_on(job: Job) -> None:
    start = true_place(job)
    spawned_and_driven(job)
    driven, time = place(job), job.session.time
    assert driven[0] > 0.2
    job.ask("reset", scope="state")
    assert true_place(job) == pytest.approx(start, abs=1e-3)
    assert true_place(job, "late") == pytest.approx((0.0, 5.0), abs=1e-3)
    job.session.step()
    assert job.session.time == time + job.session.clock.delta
    assert place(job)[:2] == pytest.approx(start, abs=2e-3)
    stamps = [nanoseconds(message.clock) for message in job.heard("/clock")]
    assert stamps == sorted(stamps)


def test_a_reset_of_the_time_begins_anew_where_robots_are(job: Job) -> None:
    spawned_and_driven(job)
    there = true_place(job)
    job.ask("reset", scope="time")
    assert (job.session.time, job.session.roster.spawned) == (0.0, ["late"])
    assert true_place(job) == there
    job.run(1.0)
    stamps = [nanoseconds(message.clock) for message in job.heard("/clock")]
    assert stamps[-60:] == [tick * 10**9 // 60 for tick in range(1, 61)]
    assert job.velocity("/one/odom") == pytest.approx((0.0, 0.0), abs=0.01)  # nobody told it to drive on
    scans = [nanoseconds(scan.header.stamp) for scan in job.heard("/one/sim_lidar/scan")]
    assert min(scans[-20:]) < 10**9


def test_a_reset_of_what_came_takes_it_away_and_nothing_else(job: Job) -> None:
    spawned_and_driven(job)
    job.ask(
        "spawn",
        name="later",
        use=LATE.model_copy(update={"namespace": "later"}).model_dump() | {"position": [0, 9, 0]},
    )
    there, time = true_place(job), job.session.time
    job.ask("reset", scope="spawned")
    assert [prim.name for prim in physics(job).stage.prims("robot")] == ["one"]
    assert (true_place(job), job.session.time) == (there, time)


def test_a_reset_of_everything_is_the_beginning(tmp_path: Path) -> None:
    heard = []
    with Job(scene(tmp_path, FIRST)) as job:
        job.drive("/one/cmd_vel", 0.5, 0.3, 1.0)
        heard.append(job.recorder.stream[:])
        spawned_and_driven(job)
        job.ask("move", entity="one", position=[5.0, 5.0, 1.0])
        job.ask("push", entity="one", force=[100.0, 0.0, 0.0], duration=100.0)
        job.run(0.1)
        job.ask("reset")
        job.recorder.stream.clear()
        job.drive("/one/cmd_vel", 0.5, 0.3, 1.0)
        heard.append(job.recorder.stream)
    assert heard[1] == heard[0]
