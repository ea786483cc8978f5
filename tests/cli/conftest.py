"""`graphrun` runs a command in this process, `project` makes a folder with the graph file mine.yaml the working directory."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from graphengine.cli import main
from tests.cli.harness import Graphrun, Result, checked
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
    for name in ("NO_COLOR", "FORCE_COLOR", "GITHUB_WORKSPACE"):
        monkeypatch.delenv(name, raising=False)

    def run(*arguments: str, **ended: Any) -> Result:
        """Run a command; `ended` is what `checked` takes."""
        capsys.readouterr()
        try:
            code = main(arguments)
        except SystemExit as end:  # as argparse ends
            code = end.code if isinstance(end.code, int) else 1
        return checked(Result(code, *capsys.readouterr()), **ended)

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
