"""Same files, seed and inputs: same bytes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from graphengine.messages.endpoints import QoS
from tests.jobs import stream
from tests.jobs.harness import ROOT, Job, Recorder
from tests.other_process import in_another_process
from tests.recording.harness import NOISY_ROBOT, NOISY_SCENE, put


@pytest.fixture(scope="module")
def drive() -> list[tuple[str, str, bytes]]:
    return stream.drive().stream


@pytest.fixture
def noisy(tmp_path: Path) -> Path:
    """A scene whose lidar is noisy."""
    put(tmp_path / "noisy_robot.yaml", NOISY_ROBOT)
    return put(tmp_path / "scene.yaml", NOISY_SCENE.replace("robots:\n", "settle: true\nrobots:\n"))


def test_a_drive_sends_what_was_to_be_expected(drive: list[tuple[str, str, bytes]]) -> None:
    assert Counter(topic for topic, _, _ in drive) == {
        "/clock": 180,
        "/dd100_0000/odom": 180,
        "/dd100_0000/tf": 180,
        "/dd100_0000/tf_static": 1,
        "/dd100_0000/platform/joint_states": 180,
        "/dd100_0000/sim_lidar/scan": 61,
    }


def test_a_second_drive_sends_the_same_bytes_in_the_same_order(drive: list[tuple[str, str, bytes]]) -> None:
    assert stream.drive().stream == drive


@pytest.mark.parametrize("hash_seed", ["0", "4242"])
def test_another_process_with_another_order_of_sets_sends_the_same_bytes(
    drive: list[tuple[str, str, bytes]], hash_seed: str
) -> None:
    done = subprocess.run(
        [sys.executable, stream.__file__],
        cwd=ROOT / "tests",
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=True,
    )
    recorder = Recorder()
    recorder.stream = drive
    assert done.stdout.strip() == recorder.digest


def test_another_seed_changes_nothing_where_there_is_no_chance(drive: list[tuple[str, str, bytes]]) -> None:
    assert stream.drive(seed=1).stream == drive


def test_another_seed_changes_the_noise_of_the_scans_and_nothing_else(noisy: Path) -> None:
    one, other = (stream.drive(noisy, seed).stream for seed in (7, 8))
    assert in_another_process(stream.stream_of, noisy, 7) == one
    assert len(one) == len(other)
    differing = {a[0] for a, b in zip(one, other, strict=True) if a != b}
    assert differing == {"/dd100_0000/sim_lidar/scan"}


def test_noise_does_not_depend_on_who_listens_when(noisy: Path) -> None:
    scan = "/dd100_0000/sim_lidar/scan"
    with Job(noisy) as always, Job(noisy, heard=False) as late:
        always.run(2.0)
        late.run(1.0)
        assert late.transport.raw(scan) == []
        heard: list[bytes] = []
        late.transport.reader(scan, "sensor_msgs/msg/LaserScan", QoS(), heard.append)
        late.run(1.0)
        assert len(heard) == 20
        assert always.transport.raw(scan)[-20:] == heard
