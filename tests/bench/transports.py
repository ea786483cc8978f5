"""What a transport costs: start, tick, discovery and memory of `dds` and `rclpy`, in turns.

python -m tests.bench.transports [TURNS]    in an environment that has rclpy

A run publishes 20 nav_msgs/Odometry at 60 Hz to another process. Start and tick are CPU time of the run; a tick has 20 messages.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.select import open_transport
from tests.waiting import reserved_domain

KINDS = ("dds", "rclpy")
TOPICS = [f"/t{number}" for number in range(20)]
ODOMETRY = "nav_msgs/msg/Odometry"
SHORT, LONG, RATE = 2, 12, 60
"""Seconds of two runs, whose difference is the cost of ticks, and ticks a second."""

PUBLISHER = "{{type: ROS2Publisher, inputs: {{topicName: {}, messagePackage: nav_msgs, messageName: Odometry}}}}"
GRAPH = "\n".join(
    [
        "format: 1\ngraph: many\nnodes:\n  Tick: OnPlaybackTick",
        *(f"  {topic[1:]}: {PUBLISHER.format(topic)}" for topic in TOPICS),
        "connections:",
        *(f"  - Tick.tick -> {topic[1:]}.execIn" for topic in TOPICS),
    ]
)


def joined(kind: str, domain: int, name: str) -> Transport:
    return open_transport(kind, JoinOptions(Domain(domain, "LOCALHOST"), name))


def read(kind: str, domain: int) -> None:
    """Read all topics until the input ends."""
    transport = joined(kind, domain, "reader")
    for topic in TOPICS:
        transport.reader(topic, ODOMETRY, QoS(), lambda data: None)
    print("ready", flush=True)
    sys.stdin.read()
    transport.close()


def discover(kind: str, domain: int) -> None:
    """Print the seconds until the domain is joined, and those until writers on all topics are matched."""
    begun = time.monotonic()
    transport = joined(kind, domain, "writer")
    print(time.monotonic() - begun)
    writers = [transport.writer(topic, ODOMETRY, QoS()) for topic in TOPICS]
    while not all(writer.matched for writer in writers):
        time.sleep(0.005)
    print(time.monotonic() - begun)
    transport.close()


def run(kind: str, graph: Path, seconds: float) -> tuple[float, float]:
    """CPU time of a run, s, and the most memory that it had, MB."""
    command = [sys.executable, "-m", "graphengine.cli", "run", str(graph), "--transport", kind, "--no-control"]
    process = subprocess.Popen([*command, "--quiet", "--for", f"{seconds}s"], stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def measure(kind: str, graph: Path, domain: int) -> dict[str, float]:
    start, _ = run(kind, graph, 1 / RATE)
    part = [sys.executable, "-m", "tests.bench.transports", kind, str(domain)]
    with subprocess.Popen([*part, "read"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as reader:
        assert reader.stdin
        assert reader.stdout
        reader.stdout.readline()
        found = subprocess.run([*part, "discover"], capture_output=True, text=True, check=True).stdout.split()
        long, memory = run(kind, graph, LONG)
        short, _ = run(kind, graph, SHORT)
        reader.stdin.close()
    return {
        "start, s of CPU": start,
        "a tick, ms of CPU": (long - short) / (LONG - SHORT) / RATE * 1e3,
        "join, s": float(found[0]),
        "all peers found, s": float(found[1]),
        "memory, MB": memory,
    }


def main(turns: int) -> None:
    """Print the median of each figure, by transport."""
    rows: dict[str, list[dict[str, float]]] = {kind: [] for kind in KINDS}
    with tempfile.TemporaryDirectory() as folder, reserved_domain() as domain:
        os.environ |= {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        graph = Path(folder, "many.yaml")
        graph.write_text(GRAPH, encoding="utf-8")
        for _ in range(turns):
            for kind in KINDS:
                rows[kind].append(measure(kind, graph, domain))
    for name in rows[KINDS[0]][0]:
        print(f"{name:20}", *(f"{kind} {statistics.median(row[name] for row in rows[kind]):8.2f}" for kind in KINDS))


if __name__ == "__main__":
    if len(sys.argv) > 3:
        {"read": read, "discover": discover}[sys.argv[3]](sys.argv[1], int(sys.argv[2]))
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
