"""What the main job costs beside physics and rays, against encoding and writing the same messages in a bare loop, in one run.

`python tests/bench/dd100.py [SECONDS]` runs `dd100_warehouse` as fast as it can over DDS, with a second process that reads every
topic. It prints ratios, the real-time factor and the resident memory; nothing is asserted. A bare loop without a pause finds its
caches hot and the reader awake, which no tick does; so physics and rays run between the baseline's batches, and are not counted.
"""

from __future__ import annotations

import itertools
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from graphengine.devices.lidar import Lidar
from graphengine.format.files import find_file
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.physics.simulation import Simulation
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.topic_endpoints import LivePublisher
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build

DOMAIN = Domain(87, "LOCALHOST")
ROUNDS = 7
Recorded = list[tuple[int, Any, Any]]


class Stopwatch:
    """Adds up the time of wrapped calls."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Start anew."""
        self.seconds, self.calls = 0.0, 0

    def wrap(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, timed."""

        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            try:
                return function(*arguments)
            finally:
                self.seconds += time.perf_counter() - start
                self.calls += 1

        return timed


class TimedLidar:
    """A lidar whose casting is timed."""

    def __init__(self, lidar: Any, watch: Stopwatch) -> None:
        self._lidar = lidar
        self.scan = watch.wrap(lidar.scan)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._lidar, name)


def read_everything(topics: list[str]) -> None:
    """The second process: a reader on each `topic=type`, until it is killed."""
    transport = DdsTransport(JoinOptions(DOMAIN, "reader"))
    for entry in topics:
        topic, message_type = entry.split("=")
        transport.reader(topic, message_type, LATCHED if topic.endswith("static") else QoS(), lambda data: None)
    print("ready", flush=True)
    time.sleep(3600)


def resident_megabytes() -> float:
    """Memory of this process now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main(simulated: float) -> None:
    """Run and print."""
    assembly = build.load(find_file("dd100_warehouse"))
    topics = {f"{claim.topic}={claim.message_type}" for claim in assembly.claims if claim.direction == "publish"}
    reader = subprocess.Popen([sys.executable, __file__, "--read", *sorted(topics)], stdout=subprocess.PIPE, text=True)
    network = LiveNetwork(lambda domain: DdsTransport(JoinOptions(DOMAIN, "bench")), DOMAIN.id, print)
    world: Any = Simulation
    rays, steps, lidars = Stopwatch(), Stopwatch(), []
    make_device, step = world.device, world.step

    def timed_device(simulation: Any, interface: Any, prim: Any, **options: Any) -> Any:
        made = make_device(simulation, interface, prim, **options)
        if interface is not Lidar:
            return made
        lidars.append(made)
        return TimedLidar(made, rays)

    world.device, world.step = timed_device, steps.wrap(step)
    try:
        with build.start(assembly, network) as session:
            assert reader.stdout is not None
            reader.stdout.readline()
            _wait_for_readers(session)
            session.step(60)  # warm
            early = resident_megabytes()
            rounds = [_round(session, simulated / ROUNDS, steps, rays, lidars) for _ in range(ROUNDS)]
            late = resident_megabytes()
    finally:
        reader.kill()
    rate, step, scan, rest, paced, bare = (statistics.median(column) for column in zip(*rounds, strict=True))
    print(f"{ROUNDS} rounds of {simulated / ROUNDS:g} s, medians; us and ratios a tick")
    print(f"real-time factor {rate:.1f} (bar 10); step {step:.0f} us; {scan / 1e3:.2f} ms a scan")
    print(f"all the rest {rest:.0f} us; encoding and writing the same messages in a bare loop:")
    ratios = sorted(r[3] / r[4] for r in rounds)
    low, middle, high = ratios[0], statistics.median(ratios), ratios[-1]
    print(f"  with steps and rays in between {paced:.0f} us, ratio {middle:.2f} ({low:.2f} to {high:.2f}; bar 1.5)")
    print(f"  without a pause, caches hot and the reader awake {bare:.0f} us, ratio {rest / bare:.2f}")
    print(f"resident {early:.0f} MB at the start, {late:.0f} MB at the end (bar 350)")


def _round(
    session: SessionCore, simulated: float, steps: Stopwatch, rays: Stopwatch, lidars: list[Any]
) -> tuple[float, float, float, float, float, float]:
    """One measured stretch, then a recorded one whose messages the loops send again."""
    network: Any = session.services.network
    steps.clear()
    rays.clear()
    sent, start = network.sent, time.perf_counter()
    session.run(simulated)
    wall, sent = time.perf_counter() - start, network.sent - sent
    rest, ticks = wall - steps.seconds - rays.seconds, simulated / session.clock.delta
    step, scan = steps.seconds / steps.calls * 1e6, rays.seconds / rays.calls * 1e6
    # Recording keeps every message alive, which costs; so it is done over a stretch of its own.
    recorded = _record(session, simulated)
    scale = sent / len(recorded) / ticks * 1e6
    paced, bare = _paced_loop(recorded, session.services.world, lidars), _bare_loop(recorded)
    return simulated / wall, step, scan, rest / ticks * 1e6, paced * scale, bare * scale


def _wait_for_readers(session: SessionCore) -> None:
    session.step(1)
    deadline = time.monotonic() + 20
    while not all(publisher.wanted for publisher in _publishers(session)) and time.monotonic() < deadline:
        time.sleep(0.05)


def _publishers(session: SessionCore) -> list[LivePublisher]:
    nodes = [node for run in session.graphs for node in run.executor.nodes]
    found = [getattr(node, "publisher", None) for node in nodes]
    return [publisher for publisher in found if isinstance(publisher, LivePublisher)]


def _record(session: SessionCore, simulated: float) -> Recorded:
    """Run on, and note every message with its tick and writer."""
    recorded: Recorded = []
    original = LivePublisher.publish

    def publish(self: LivePublisher, message: Any) -> None:
        recorded.append((session.clock.frame, self._end, message))
        original(self, message)

    LivePublisher.publish = publish  # type: ignore[method-assign]
    session.run(simulated)
    LivePublisher.publish = original  # type: ignore[method-assign]
    return recorded


def _bare_loop(recorded: Recorded) -> float:
    """Encode and write what was recorded, and nothing else."""
    start = time.perf_counter()
    for _, writer, message in recorded:
        writer.write(messages.encode(message))
    return time.perf_counter() - start


def _paced_loop(recorded: Recorded, world: Any, lidars: list[Any]) -> float:
    """The same with caches and the reader as a tick finds them: physics and rays run in between, and are not counted."""
    seconds = 0.0
    for frame, group in itertools.groupby(recorded, key=lambda entry: entry[0]):
        batch = list(group)
        for _ in range(world.substeps):
            world.step()
        world.begin_tick(frame)
        for lidar in lidars:
            if lidar.due:
                lidar.reset()
                lidar.scan()
        start = time.perf_counter()
        for _, writer, message in batch:
            writer.write(messages.encode(message))
        seconds += time.perf_counter() - start
    return seconds


if __name__ == "__main__":
    if sys.argv[1:2] == ["--read"]:
        read_everything(sys.argv[2:])
    else:
        main(float(sys.argv[1]) if sys.argv[1:] else 30.0)
