"""How fast a recording can be looked at: `python -m tests.bench.recording_view [SECONDS]`; figures are printed, none is asserted.

It records a drive through dd100_warehouse, replays it as `graphrun view` does in the background, and seeks to random times.
"""

from __future__ import annotations

import random
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import graphengine as ge
from graphengine.recording.player import RecordingPlayer
from tests.recording.harness import playing

SEEKS = 100


def main(seconds: float) -> None:
    """Print the times of the build, of seeks, of single steps and of the changes between building and showing."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.mcap"
        with ge.load("dd100_warehouse").session(record=path) as sim:
            sim.robots["dd100"].publish("cmd_vel", {"linear": {"x": 0.5}, "angular": {"z": 0.2}}, every=0.1)
            sim.run(seconds)
        with playing(path) as player:
            begin, cpu = time.perf_counter(), time.thread_time()
            player.build()
            print(
                f"{seconds:g} s replayed in {time.perf_counter() - begin:.2f} s (bar 5 for 60 s),"
                f" {time.thread_time() - cpu:.2f} s of it computing; {player.built} ticks"
            )
            chance = random.Random(1)
            tell("seek", [seek(player, chance.randrange(player.built)) for _ in range(SEEKS)], "(bar 300)")
            tell("step back", [seek(player, player.position - 1) for _ in range(SEEKS)])
        with playing(path) as player:
            tell("frame while it is built", [frame(player) for _ in range(20)])


Times = tuple[float, float]
"""Wall time and processor time, ms."""


def seek(player: RecordingPlayer, tick: int) -> Times:
    """The time until a tick is shown."""
    begin, cpu = time.perf_counter(), time.thread_time()
    player.show(tick)
    return (time.perf_counter() - begin) * 1e3, (time.thread_time() - cpu) * 1e3


def frame(player: RecordingPlayer) -> Times:
    """The time until the shown tick has moved on by three, after a slice of the build."""
    player.build(0.04)
    return seek(player, player.position + 3)


def tell(what: str, times: Sequence[Times], bar: str = "") -> None:
    """Print the median and the most; processor time is what a machine without other work would take."""
    wall, cpu = zip(*times, strict=True)
    print(
        f"{what}: median {statistics.median(wall):.1f} ms, most {max(wall):.1f} ms,"
        f" computing {statistics.median(cpu):.1f} and {max(cpu):.1f} ms {bar}".rstrip()
    )


if __name__ == "__main__":
    main(float(sys.argv[1]) if sys.argv[1:] else 60.0)
