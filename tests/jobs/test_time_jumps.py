"""What others learn of the time when it jumps: /clock at once, even while nothing runs, and nothing but /clock."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.format.spec import RobotUse
from tests.jobs.harness import Job, nanoseconds
from tests.other_process import in_another_process

SCENE = """scene: jumps
world: worlds/flat_grid.xml
robots:
  bot: {use: robots/dd100.yaml, position: [0, 0, 0.025]}
graphs:
  clock: {use: graphs/clock.yaml, at: /World/clock}
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")
    return tmp_path / "scene.yaml"


def stamps(job: Job) -> list[int]:
    """Times on /clock, ns."""
    job.session.services.network.flush()
    return [nanoseconds(message.clock) for message in job.heard("/clock")]


@pytest.mark.parametrize(("command", "arguments"), [("stop", {}), ("reset", {}), ("reset", {"scope": "time"})])
def test_a_jump_to_the_beginning_is_announced_at_once_and_once(
    path: Path, command: str, arguments: dict[str, str]
) -> None:
    with Job(path) as job:
        job.run(1.0)
        sent = len(job.recorder.stream)
        job.ask(command, **arguments)
        assert [topic for topic, _, _ in job.recorder.stream[sent:]] == ["/clock"]
        assert stamps(job)[-2:] == [1_000_000_000, 0]
        job.run(0.1)
        assert stamps(job)[61:63] == [16_666_666, 33_333_333]


def test_a_checkpoints_time_is_announced(path: Path) -> None:
    with Job(path) as job:
        job.run(0.5)
        kept = job.session.checkpoint()
        job.run(0.5)
        job.session.restore(kept)
        assert stamps(job)[-2:] == [1_000_000_000, 500_000_000]
        job.session.step()
        assert stamps(job)[-1] == 516_666_666


def test_the_restart_by_a_changed_robot_is_announced(path: Path) -> None:
    with Job(path) as job:
        job.run(0.5)
        path.write_text(SCENE.replace("[0, 0, 0.025]", "[1, 0, 0.025]"), encoding="utf-8")
        assert job.session.reload().restarted
        assert stamps(job)[-2:] == [500_000_000, 0]


def test_nothing_is_announced_where_the_time_stays(path: Path) -> None:
    with Job(path) as job:
        job.ask("reset")
        job.run(0.5)
        before = stamps(job)
        kept = job.session.checkpoint()
        job.session.restore(kept)
        job.ask("reset", scope="state")
        job.spawn("more", RobotUse(use="robots/dd100.yaml", position=(0.0, 5.0, 0.025), namespace="more"))
        job.session.reload()
        job.session.pause()
        assert stamps(job) == before
        assert 0 not in before


def test_a_clock_that_continues_after_stop_does_not_jump(path: Path) -> None:
    with Job(path, {"clock/ReadSimTime.resetOnStop": False}) as job:
        job.run(0.5)
        job.ask("reset")
        job.run(0.1)
    times = stamps(job)
    assert times == sorted(times)


def digest_around_a_reset(path: Path) -> str:
    with Job(path) as job:
        job.run(0.2)
        job.ask("reset")
        job.run(0.2)
        return job.recorder.digest


def test_a_reset_by_a_command_gives_the_same_bytes_in_another_process(path: Path) -> None:
    assert in_another_process(digest_around_a_reset, path) == digest_around_a_reset(path)
