"""`graphrun run --foxglove`: a client sees, drives and outlives robots of a run, and the recording has all of it."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.reader import make_reader

from graphengine.messages import messages
from tests.cli.harness import Graphrun, Live, environment, live
from tests.jobs.harness import twist
from tests.ros.foxglove_client import FoxgloveClient

MEMORY = ("--transport", "memory")
ODOM, CMD_VEL, TWIST = "/dd100_0000/odom", "/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist"


@pytest.fixture(autouse=True)
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No run of others can be reached by `graphrun ctl`."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    return tmp_path / "out.mcap"


@pytest.fixture
def run(recording: Path) -> Iterator[Live]:
    """A run that waits at time 0, and is recorded."""
    words = (
        "run",
        "dd100_flat",
        "--paused",
        "--foxglove",
        "0",
        "--foxglove-publish",
        "--record",
        str(recording),
        *MEMORY,
    )
    with live(*words) as running:
        assert running.hear(lambda said: re.search(r"recording to .*\nFoxglove at .*\n", said) is not None)
        yield running


@pytest.fixture
def client(run: Live) -> Iterator[FoxgloveClient]:
    found = re.search(r"Foxglove at (ws://127\.0\.0\.1:\d+/\?token=\S+)\n", run.said)
    assert found
    with FoxgloveClient(found[1]) as connected:
        yield connected


def recorded(path: Path, topic: str) -> list[bytes]:
    with path.open("rb") as file:
        return [message.data for _, _, message in make_reader(file).iter_messages(topics=[topic])]


def test_a_client_drives_a_robot_and_a_replay_repeats_it(
    run: Live, client: FoxgloveClient, recording: Path, graphrun: Graphrun
) -> None:
    client.subscribe(ODOM, CMD_VEL)
    client.advertise(CMD_VEL, TWIST)(messages.encode(twist(0.5, 0.0)))
    assert client.until(lambda: client.messages[CMD_VEL])
    assert graphrun("ctl", "step", "60").code == 0
    assert client.until(lambda: len(client.messages[ODOM]) == 60)
    assert messages.decode(client.messages[ODOM][-1], "nav_msgs/msg/Odometry").pose.pose.position.x > 0.2
    assert run.stop(signal.SIGINT) == 0
    assert client.until(lambda: client.closed)
    assert recorded(recording, ODOM) == client.messages[ODOM]
    assert recorded(recording, CMD_VEL) == client.messages[CMD_VEL]
    replayed = graphrun("replay", str(recording), code=0)
    assert replayed.out.startswith("identical: ")


def test_without_the_option_a_client_reads_and_does_not_drive(graphrun: Graphrun) -> None:
    with live("run", "dd100_flat", "--paused", "--foxglove", "0", *MEMORY) as run:
        assert run.hear(lambda said: re.search(r"^Foxglove at \S+\n", said, re.MULTILINE) is not None)
        (url,) = re.findall(r"^Foxglove at (ws://127\.0\.0\.1:\d+)\n", run.said, re.MULTILINE)
        with FoxgloveClient(url) as client:
            client.advertise(CMD_VEL, TWIST)(messages.encode(twist(0.5, 0.0)))
            client.subscribe(ODOM)
            assert graphrun("ctl", "step", "60").code == 0
            assert client.until(lambda: len(client.messages[ODOM]) == 60)
            odometry = messages.decode(client.messages[ODOM][-1], "nav_msgs/msg/Odometry")
            assert abs(odometry.pose.pose.position.x) < 0.01


def test_a_quiet_run_prints_the_address_for_foxglove() -> None:
    with live("run", "dd100_flat", "--paused", "--foxglove", "0", "--foxglove-publish", "--quiet", *MEMORY) as run:
        assert run.hear(lambda said: re.match(r"Foxglove at ws://127\.0\.0\.1:\d+/\?token=\S+\n", said) is not None)


def test_publishing_needs_a_port(graphrun: Graphrun) -> None:
    assert "--foxglove-publish needs --foxglove [HOST:]PORT" in graphrun("run", "x", "--foxglove-publish", code=2).err


def test_topics_of_robots_come_and_go_with_them(client: FoxgloveClient, graphrun: Graphrun) -> None:
    client.subscribe(ODOM)
    before = {*client.channels}
    assert graphrun("ctl", "spawn", "late", "robots/dd100.yaml", "--at", "0,3,0.03", "--namespace", "two").code == 0
    client.subscribe("/two/odom")
    assert {topic.replace("/two/", "/dd100_0000/") for topic in client.channels} == before
    assert graphrun("ctl", "step").code == 0
    assert client.until(lambda: client.messages["/two/odom"])
    assert graphrun("ctl", "delete", "late").code == 0
    assert client.until(lambda: {*client.channels} == before)


def test_a_run_that_foxglove_sees_is_in_real_time(graphrun: Graphrun, project: Path) -> None:
    begun = time.monotonic()
    graphrun("run", "mine.yaml", "--foxglove", "0", "--for", "500ms", *MEMORY, code=0)
    assert time.monotonic() - begun > 0.4


def test_a_port_that_is_taken_ends_the_run_with_one_line(client: FoxgloveClient, graphrun: Graphrun, run: Live) -> None:
    found = re.search(r"127\.0\.0\.1:(\d+)", run.said)
    assert found
    address = found[0]
    what = f"error: Foxglove cannot be served at {address}: Address already in use (os error 98)\n"
    graphrun("run", "dd100_flat", "--foxglove", found[1], *MEMORY, code=1, err=what)


@pytest.mark.parametrize("text", ["here", "99999", "host:", ":8765", "::1", "-1", "ws://host:1"])
def test_an_illegal_address_is_refused(graphrun: Graphrun, text: str) -> None:
    result = graphrun("run", "dd100_flat", f"--foxglove={text}", code=2)
    assert f"{text!r} is not an address; write PORT or HOST:PORT, such as 8765 or 0.0.0.0:8765" in result.err


def test_a_run_that_foxglove_does_not_see_does_not_import_its_sdk(project: Path) -> None:
    program = "import sys; from graphengine.cli import main; main(sys.argv[1:]); assert 'foxglove' not in sys.modules"
    words = ("run", "mine.yaml", "--for", "100ms", *MEMORY)
    done = subprocess.run(
        [sys.executable, "-c", program, *words],
        cwd=project,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_values_of_ports_are_channels_of_their_own(graphrun: Graphrun) -> None:
    channel = "/_graph/dd100/joint_states/ComputeOdom.position"
    words = ("--foxglove", "0", "--ports", "*/ComputeOdom.*", *MEMORY)
    with live("run", "dd100_flat", "--paused", *words) as run:
        assert run.hear(lambda said: re.search(r"^Foxglove at \S+\n", said, re.MULTILINE) is not None)
        (url,) = re.findall(r"^Foxglove at (ws://127\.0\.0\.1:\d+)\n", run.said, re.MULTILINE)
        with FoxgloveClient(url) as client:
            client.subscribe(ODOM, channel)
            assert graphrun("ctl", "step", "30").code == 0
            assert client.until(lambda: len(client.messages[channel]) == len(client.messages[ODOM]) == 30)
            assert channel.replace("position", "linearVelocity") in client.channels
            sent = messages.decode(client.messages[channel][-1], "std_msgs/msg/Float64MultiArray").data
            position = messages.decode(client.messages[ODOM][-1], "nav_msgs/msg/Odometry").pose.pose.position
            assert sent.tolist() == [position.x, position.y, position.z]
