"""`graphrun run --record`: where it may write, and what it leaves however the run ends."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
from pathlib import Path

import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader

from graphengine.format.files import shipped
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import Graphrun, live, process
from tests.jobs.harness import twist
from tests.recording.harness import CLOCK, CMD_VEL, put
from tests.waiting import eventually

MEMORY = ("--transport", "memory")
ODOM, ODOMETRY = "/dd100_0000/odom", "nav_msgs/msg/Odometry"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("out.bag", "expected a file name that ends in .mcap, in an existing folder, such as out.mcap"),
        ("nowhere/out.mcap", "expected a file name that ends in .mcap, in an existing folder, such as out.mcap"),
        ("there.mcap", "already exists; --force overwrites it"),
    ],
)
def test_an_unwritable_recording_path_is_refused_before_the_run(
    graphrun: Graphrun, project: Path, name: str, expected: str
) -> None:
    (project / "there.mcap").write_bytes(b"mine")
    graphrun("run", "mine.yaml", "--record", name, *MEMORY, code=2, err=f"graphrun run: --record {name}: {expected}\n")
    assert (project / "there.mcap").read_bytes() == b"mine"


def test_force_writes_over_a_file(graphrun: Graphrun, project: Path) -> None:
    (project / "there.mcap").write_bytes(b"mine")
    assert graphrun("run", "mine.yaml", "--for", "1", "--record", "there.mcap", "--force", *MEMORY).code == 0
    assert graphrun("replay", "there.mcap").out == "identical: 60 messages in 60 ticks, 1.000 s\n"


def test_a_file_with_errors_leaves_no_recording(graphrun: Graphrun, project: Path) -> None:
    (project / "mine.yaml").write_text(CLOCK.replace("Clock.execIn", "Clok.execIn"), encoding="utf-8")
    assert graphrun("run", "mine.yaml", "--record", "out.mcap", *MEMORY).code == 1
    assert not (project / "out.mcap").exists()


def test_a_run_without_ticks_is_replayed_identically(graphrun: Graphrun, project: Path) -> None:
    assert graphrun("run", "mine.yaml", "--for", "0", "--record", "out.mcap", *MEMORY).code == 0
    assert graphrun("replay", "out.mcap").out == "identical: 0 messages in 0 ticks, 0.000 s\n"


@pytest.mark.parametrize("size", [1, 200_000, 1_000_000])
def test_a_killed_run_leaves_a_readable_recording(graphrun: Graphrun, tmp_path: Path, size: int) -> None:
    path = tmp_path / "out.mcap"
    with live("run", "dd100_flat", "--record", str(path), *MEMORY) as run:
        assert eventually(lambda: path.exists() and path.stat().st_size >= size)
        run.process.kill()
        run.process.wait()
    found = 0
    with path.open("rb") as file, contextlib.suppress(EndOfFile):
        for _ in NonSeekingReader(file, validate_crcs=True).iter_messages(log_time_order=False):
            found += 1
    assert found > 60 or size == 1
    result = graphrun("replay", str(path))
    if found:
        assert result.code == 0
        assert "warning: the run was cut off: the recording ends at t = " in result.err
        assert result.out.startswith(f"identical: {found} messages in ")
    else:
        assert (result.code, result.out) == (2, "")
        assert result.err == f"graphrun replay: {path}: it was cut off before the first tick\n"


def test_a_file_at_its_size_limit_ends_the_run_and_keeps_the_recorded_ticks(graphrun: Graphrun, tmp_path: Path) -> None:
    limited = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))"
    put(tmp_path / "limit" / "sitecustomize.py", limited)
    path = tmp_path / "out.mcap"
    env = {"PYTHONPATH": os.pathsep.join([str(tmp_path / "limit"), str(shipped())])}
    result = process("run", "dd100_flat", "--for", "60s", "--record", str(path), *MEMORY, env=env, code=1)
    assert f"error: {path}: the recording cannot be written: File too large\n" in result.err
    assert "Traceback" not in result.err
    result = graphrun("replay", str(path))
    assert (result.code, result.out[:11]) == (0, "identical: ")
    assert "cut off" in result.err


def test_a_run_over_dds_is_replayed_identically(graphrun: Graphrun, domain_id: int, tmp_path: Path) -> None:
    path, odometry = tmp_path / "out.mcap", list[bytes]()
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with contextlib.closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as peer:
        writer = peer.writer(CMD_VEL, "geometry_msgs/msg/Twist", QoS())
        peer.reader(ODOM, ODOMETRY, QoS(), odometry.append)
        with live("run", "dd100_flat", "--transport", "dds", "--record", str(path), env=env) as run:
            assert run.hear(lambda said: f"domain {domain_id}" in said)
            speeds_to_write = itertools.cycle(range(10))

            def moves() -> bool:  # that the writer is matched does not tell that the run knows of it
                writer.write(messages.encode(twist(0.1 * next(speeds_to_write), 0.0)))
                return any(messages.decode(data, ODOMETRY).twist.twist.linear.x > 0.01 for data in odometry[-1:])

            assert eventually(moves), run.said
            assert run.stop(signal.SIGINT) == 0, run.said
    with path.open("rb") as file:
        speeds = [
            messages.decode(message.data, schema.name).linear.x
            for schema, channel, message in NonSeekingReader(file).iter_messages(topics=[CMD_VEL])
            if schema
        ]
    assert speeds
    assert set(speeds) <= {0.1 * speed for speed in range(10)}
    graphrun("replay", str(path), code=0, err="")
