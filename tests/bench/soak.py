"""A long run that may neither leak nor lose anything: memory, files, threads and every message are counted.

`python tests/bench/soak.py [--minutes 30] [--robots 10] [--transport memory|dds] [--rate max|realtime]` lets robots drive in
circles, with all their topics, and prints a line a minute of simulation. A peer, over DDS in a process of its own, reads all of
it and sends the robots' commands; nobody else may be in the domain, which `--domain` names. Memory is compared with what it was
after the first minute of simulation. Messages are counted where they are sent and where they arrive. What did not arrive is
lost; reported is what our side says that it gave up. It ends with 1 where memory grew by more than 1 %, files or threads became
more, or what was lost is not what was reported.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options

DOMAIN = 88
TWIST = "geometry_msgs/msg/Twist"
CIRCLE = messages.encode(messages.Twist(messages.Vector3(0.2, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.8)))
DRIVE_EVERY = 0.05
"""Seconds of the wall clock between two commands to each robot."""
MAX_GROWTH = 0.01
SCENE = """scene: soak
world: worlds/full_warehouse.xml
settle: true
robots:
  dd100: {{use: robots/dd100.yaml, count: {robots}, per_row: 13, spacing: [1.2, 1.2], position: [-25.0, -12.6, 0.025]}}
graphs:
  clock: {{use: graphs/clock.yaml, at: /World/clock}}
"""


class Peer:
    """Reads all that is published, and sends commands.

    Args:
        transport: where.
        topics: as `topic=type` those to be read, of commands those to be written.
    """

    def __init__(self, transport: Transport, topics: Sequence[str]) -> None:
        self.read: Counter[str] = Counter()
        self.sent: Counter[str] = Counter()
        self.writers = []
        for topic, kind in (entry.split("=") for entry in topics):
            if kind == TWIST:
                self.writers.append((topic, transport.writer(topic, kind, QoS())))
            else:
                qos = LATCHED if topic.endswith("static") else QoS()
                transport.reader(topic, kind, qos, partial(self._take, topic))

    def _take(self, topic: str, data: bytes) -> None:
        self.read[topic] += 1

    def drive(self) -> None:
        """One command to each robot."""
        for topic, writer in self.writers:
            writer.write(CIRCLE)
            self.sent[topic] += 1


class Neighbour(Peer):
    """A peer in this process."""

    def finish(self) -> None:
        """All has been counted."""


class Stranger:
    """A peer in another process, which drives by the wall clock."""

    def __init__(self, domain: Domain, topics: Sequence[str]) -> None:
        command = [sys.executable, __file__, "--peer", str(domain.id), *topics]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.read: Counter[str] = Counter()
        self.sent: Counter[str] = Counter()
        self._line()

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()

    def drive(self) -> None:
        """It does so by itself."""

    def finish(self) -> None:
        """Ask what came and went, once nothing more comes."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self.read, self.sent = map(Counter, json.loads(self._line()))
        self._process.wait()


def be_a_stranger(domain: Domain, topics: Sequence[str]) -> None:
    """The other process: drives until its input ends, reads until nothing more comes, and tells its counts."""
    transport = DdsTransport(JoinOptions(domain, "peer"))
    peer, reading = Peer(transport, topics), threading.Thread(target=sys.stdin.read, daemon=True)
    print("ready", flush=True)
    reading.start()
    while not all(writer.matched for _, writer in peer.writers):
        time.sleep(0.05)
    time.sleep(1.0)
    while reading.is_alive():
        time.sleep(DRIVE_EVERY)
        peer.drive()
    before = -1
    while before != peer.read.total():
        before = peer.read.total()
        time.sleep(1.0)
    print(json.dumps([peer.read, peer.sent]), flush=True)
    transport.close()


class Tally:
    """Counts what is sent."""

    def __init__(self) -> None:
        self.sent: Counter[str] = Counter()

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """A message leaves."""
        self.sent[claim.topic] += 1

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Subscriptions count by themselves."""


class Held(NamedTuple):
    """What a process holds."""

    megabytes: float
    files: int
    threads: int

    @classmethod
    def look(cls) -> Held:
        """Now; memory is resident memory, without what only waits for Python's collector."""
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        size = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
        return cls(size, len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task")))

    def __str__(self) -> str:
        return f"{self.megabytes:.2f} MB, {self.files} files, {self.threads} threads"


def main(arguments: argparse.Namespace) -> int:
    """Run, print, and tell whether all is well."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "soak.yaml"
        path.write_text(SCENE.format(robots=arguments.robots), encoding="utf-8")
        assembly = build.load(path, Options({"SubscribeTwist.timeout": 0.0}))
    topics = sorted({f"{claim.topic}={claim.message_type}" for claim in assembly.claims})
    remote = arguments.transport == "dds"
    hurried, domain = arguments.rate == "max", Domain(arguments.domain, "LOCALHOST")
    transport: Transport = (
        DdsTransport(JoinOptions(domain, "soak", patient=hurried)) if remote else MemoryTransport(keeps=False)
    )
    network, tally = LiveNetwork(lambda _: transport, domain.id, print), Tally()
    with build.start(assembly, network) as session:
        peer = Stranger(domain, topics) if remote else Neighbour(transport, topics)
        wait_for(network)
        network.sinks.append(tally)
        looks = run(session, peer, arguments.minutes, None if hurried else 1.0)
        peer.finish()
        network.freeze()
        well = judge(looks)
        return 0 if all([well, account(network, tally, peer)]) else 1


def wait_for(network: LiveNetwork) -> None:
    """Begin when all topics are read, so that nothing is sent to nobody."""
    deadline = time.monotonic() + 60
    while not all(publisher.wanted for publisher in network.publishers):
        if time.monotonic() > deadline:
            raise SystemExit("nobody reads: is something else in the domain?")
        time.sleep(0.05)
    time.sleep(1.0)


def run(session: SessionCore, peer: Neighbour | Stranger, minutes: int, pace: float | None) -> list[Held]:
    """What is held after each minute of simulation."""
    looks = []
    ticks = round(DRIVE_EVERY / session.clock.delta)

    def drive(session: SessionCore) -> bool:
        if session.clock.frame % ticks == 0:
            peer.drive()
        return True

    for minute in range(1, minutes + 1):
        start, cpu = time.perf_counter(), time.process_time()
        session.run(60.0, pace, drive)
        wall, cpu = time.perf_counter() - start, time.process_time() - cpu
        looks.append(Held.look())
        print(f"{minute:3} min, x{60 / wall:.2f}, {cpu / wall:.0%} of a core: {looks[-1]}", flush=True)
    return looks


def judge(looks: Sequence[Held]) -> bool:
    """Compare the end with the first minute."""
    first, last = looks[0], looks[-1]
    growth = last.megabytes / first.megabytes - 1
    more = last.files > first.files or last.threads > first.threads
    print(f"memory grew by {growth:.2%} after the first minute; files {first.files} to {last.files}, ", end="")
    print(f"threads {first.threads} to {last.threads}")
    return growth <= MAX_GROWTH and not more


def account(network: LiveNetwork, tally: Tally, peer: Neighbour | Stranger) -> bool:
    """Compare what was sent with what arrived, and the difference with what was reported."""
    heard = Counter({end.topic: end.heard for end in network.subscriptions})
    well = True
    for what, sent, arrived, reported in (
        ("published", tally.sent, peer.read, network.given_up),
        ("commands", peer.sent, heard, Counter()),
    ):
        lost = sent - arrived
        print(
            f"{what}: {sent.total()} sent on {len(sent)} topics, {arrived.total()} arrived, {lost.total()} lost", end=""
        )
        print(f", {reported.total()} reported as given up")
        for topic, number in lost.most_common(5):
            print(f"  lost of {topic}: {number} of {sent[topic]}")
        well &= lost == reported and not arrived - sent
    ends = network.subscriptions
    print(
        f"commands that arrived: {sum(end.skipped for end in ends)} skipped for newer ones in the same tick, ", end=""
    )
    print(f"{network.overwritten.total()} reported as overwritten, {sum(end.malformed for end in ends)} malformed")
    return well


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=int, default=30, help="of simulation")
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--transport", choices=("memory", "dds"), default="memory")
    parser.add_argument("--rate", choices=("max", "realtime"), default="max")
    parser.add_argument("--domain", type=int, default=DOMAIN, help="of ROS 2, with nobody else in it")
    return parser.parse_args()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peer"]:
        be_a_stranger(Domain(int(sys.argv[2]), "LOCALHOST"), sys.argv[3:])
    else:
        sys.exit(main(parse()))
