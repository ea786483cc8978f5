"""What recording costs a tick: the same scene with and without, round by round in one run.

`python tests/bench/record.py [SCENE] [SECONDS]` runs a scene with a robot that drives in circles as fast as it can: once where
everything is heard, and once where it is recorded besides. It prints milliseconds a tick, the longest ticks, and what the file
grows by; nothing is asserted.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from graphengine.format.files import find_file
from graphengine.messages import messages
from graphengine.recording.recorder import Recorder
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.scene import build

ROUNDS = 7
CIRCLE = messages.encode(messages.Twist(messages.Vector3(0.5, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.4)))
COMMAND_EVERY = 6
"""Ticks between two commands."""


class Round(NamedTuple):
    """Milliseconds of the clock of each tick, and of the processor a tick."""

    times: list[float]
    cpu: float


class Side:
    """The scene on one of the two sides.

    Args:
        scene: the name of one that ships.
        record: the file that it is recorded to; None on the other side.
        stack: closes all of it.
    """

    def __init__(self, scene: str, record: Path | None, stack: ExitStack) -> None:
        assembly = build.load(find_file(scene))
        self.transport = MemoryTransport(wants_all=True, keeps=False, definitions=assembly.definitions)
        network = LiveNetwork(lambda _: self.transport, 0, print, assembly.definitions)
        self.session = stack.enter_context(build.start(assembly, network))
        self.commanded = [claim.topic for claim in assembly.claims if claim.topic.endswith("/cmd_vel")]
        if record is not None:
            stack.enter_context(Recorder(self.session, network, assembly, record))

    def run(self, ticks: int) -> Round:
        """Run on, and take the time."""
        times, cpu = [], time.process_time()
        for tick in range(ticks):
            if tick % COMMAND_EVERY == 0:
                for topic in self.commanded:
                    self.transport.inject(topic, CIRCLE)
            start = time.perf_counter()
            self.session.step()
            times.append((time.perf_counter() - start) * 1e3)
        return Round(times, (time.process_time() - cpu) / ticks * 1e3)


def main(scene: str, seconds: float) -> None:
    """Run and print."""
    with ExitStack() as stack:
        path = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "bench.mcap"
        sides = [Side(scene, record, stack) for record in (None, path)]
        delta = sides[0].session.clock.delta
        ticks = round(seconds / ROUNDS / delta)
        for side in sides:
            side.run(ticks)  # warm
        before = path.stat().st_size
        rounds = [[side.run(ticks) for side in sides] for _ in range(ROUNDS)]
        grown = path.stat().st_size - before
    heard, recorded = zip(*rounds, strict=True)
    print(f"{scene}: {ROUNDS} rounds of {ticks} ticks, medians of the rounds; ms a tick")
    _compare("of the processor, all threads", [one.cpu for one in heard], [one.cpu for one in recorded])
    _compare(
        "of the clock", [statistics.mean(one.times) for one in heard], [statistics.mean(one.times) for one in recorded]
    )
    for name, side_rounds in (("heard", heard), ("recorded besides", recorded)):
        times = sorted(time for one in side_rounds for time in one.times)
        print(
            f"  {name}: 99 % of the ticks take less than {times[-len(times) // 100]:.2f} ms, the longest {times[-1]:.2f} ms"
        )
    print(f"  the file grows by {grown / (ROUNDS * ticks * delta) / 1e6:.2f} MB in a second of simulation")


def _compare(what: str, heard: list[float], recorded: list[float]) -> None:
    ratios = sorted(b / a for a, b in zip(heard, recorded, strict=True))
    print(f"  {what}: heard {statistics.median(heard):.3f}, recorded besides {statistics.median(recorded):.3f}", end="")
    print(f", ratio {statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f})")


if __name__ == "__main__":
    main(sys.argv[1] if sys.argv[1:] else "dd100_warehouse", float(sys.argv[2]) if sys.argv[2:] else 70.0)
