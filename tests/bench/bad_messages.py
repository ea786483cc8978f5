"""Random messages at every type of subscribing node, over DDS: the run lives, and its recording replays.

`python tests/bench/bad_messages.py [--messages 10000] [--domain 87]` sends a dd100 in its warehouse so many messages of each
type, most of them with numbers that are absurd or not finite, and with unknown joints. It prints what was sent, what
arrived, what nodes dropped and what was clamped, and replays the recording. The exit code is 1 where either fails.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from graphengine.cli import main as graphrun
from graphengine.format.errors import GraphError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.recording.recorder import Recorder
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.scene import build
from tests.jobs.bad_messages import TOPICS, bad_messages, write_scene

PER_TICK = 2
"""Messages of each type that are sent before a tick; queues hold 10."""


class Arrivals:
    """A sink of the network that counts messages by topic, besides the recording."""

    def __init__(self, recorder: Recorder) -> None:
        self.counts: Counter[str] = Counter()
        deliver = recorder.deliver

        def count(claim: object, arrived: object) -> None:
            self.counts[claim.topic] += len(arrived)  # type: ignore[attr-defined, arg-type]
            deliver(claim, arrived)  # type: ignore[arg-type]

        recorder.deliver = count  # type: ignore[method-assign]


def run(path: Path, folder: Path, count: int, domain: Domain) -> bool:
    """Send the messages, and print what became of them; whether the run lived."""
    assembly = build.load(write_scene(folder))
    network = LiveNetwork(
        lambda _: DdsTransport(JoinOptions(domain, "bad", "/")), domain.id, lambda complaint: None, assembly.definitions
    )
    draw = np.random.default_rng(0)
    made = {topic: bad_messages(kind, draw) for topic, kind in TOPICS.items()}
    with (
        build.start(assembly, network, domain_id=domain.id) as session,
        Recorder(session, network, assembly, path) as recorder,
    ):
        arrivals = Arrivals(recorder)
        peer = DdsTransport(JoinOptions(domain, "peer", "/"))
        writers = {topic: peer.writer(topic, kind, QoS()) for topic, kind in TOPICS.items()}
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline and not all(arrivals.counts[topic] for topic in TOPICS):
            for topic, writer in writers.items():
                writer.write(messages.encode(next(made[topic])))
            session.step()
        arrivals.counts.clear()
        start = time.monotonic()
        try:
            for _ in range(-(-count // PER_TICK)):
                for topic, writer in writers.items():
                    for message in itertools.islice(made[topic], PER_TICK):
                        writer.write(messages.encode(message))
                session.step()
            session.step(30)
        except GraphError as error:
            print(f"the run ended at t = {session.time:.3f} s: {error}")
            return False
        finally:
            peer.close()
        print(f"{session.ticks} ticks, {session.time:.1f} s of simulation in {time.monotonic() - start:.1f} s")
        for topic, kind in TOPICS.items():
            print(f"  {kind:42} {topic:22} sent {count}, arrived {arrivals.counts[topic]}")
        assert session.services.dropped is not None
        for node, ticks in sorted(session.services.dropped.ticks.items()):
            print(f"  dropped in {ticks} ticks at {node}")
        for command, times in sorted(session.services.world.clamped_commands.items()):
            print(f"  clamped {times} times: {command}")
    return True


def main() -> int:
    """Run and replay."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=10_000)
    parser.add_argument("--domain", type=int, default=87)
    given = parser.parse_args()
    domain = Domain.from_environment({"ROS_DOMAIN_ID": str(given.domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bad.mcap"
        lived = run(path, Path(folder), given.messages, domain)
        print(f"recorded {path.stat().st_size / 1e6:.1f} MB")
        return 0 if graphrun(["replay", str(path)]) == 0 and lived else 1


if __name__ == "__main__":
    sys.exit(main())
