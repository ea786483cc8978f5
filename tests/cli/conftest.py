"""`graphrun` runs a command in this process, `project` is a folder to stand in with a graph and a scene of one's own."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from graphengine.cli import main
from tests.cli.harness import Graphrun, Result
from tests.recording import harness as recordings

CLOCK = """format: 1
graph: mine
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Clock:
    type: PublishClock
    inputs: {topicName: clock}
connections:
  - Tick.tick -> Clock.execIn
  - Time.simulationTime -> Clock.timeStamp
"""


@pytest.fixture
def graphrun(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Graphrun:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    monkeypatch.setattr(sys, "path", list(sys.path))

    def run(*arguments: str, code: int | None = None, out: str | None = None, err: str | None = None) -> Result:
        """Run a command; it must end with the exit code, and print exactly the texts, that are given."""
        capsys.readouterr()
        try:
            ended = main(arguments)
        except SystemExit as end:  # as argparse ends
            ended = end.code if isinstance(end.code, int) else 1
        result = Result(ended, *capsys.readouterr())
        for told, wanted in ((result.code, code), (result.out, out), (result.err, err)):
            assert wanted is None or told == wanted, result
        return result

    return run


@pytest.fixture
def domain_id(domain_id: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """A ROS 2 domain that no other test is in; the environment names it."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
    for name in ("CYCLONEDDS_URI", "ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS"):
        monkeypatch.delenv(name, raising=False)
    return domain_id


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "mine.yaml").write_text(CLOCK, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of five seconds of the warehouse, commanded at odd times."""
    path = tmp_path_factory.mktemp("drive") / "drive.mcap"
    recordings.record(path, 300, commands=recordings.DRIVE)
    return path


@pytest.fixture
def clock(tmp_path: Path) -> Path:
    """A graph to be recorded, in a folder of its own."""
    return recordings.put(tmp_path / "hall" / "clock.yaml", recordings.CLOCK)
