"""What sessions of one scene cost: `python -m tests.bench.sessions [SCENE]`; figures are printed, none is asserted."""

from __future__ import annotations

import gc
import statistics
import sys
import time
from collections.abc import Callable

import graphengine as ge
from tests.bench.dd100 import resident_megabytes

SESSIONS = 50


def seconds(function: Callable[[], object]) -> float:
    """Wall time of a call."""
    begin = time.perf_counter()
    function()
    return time.perf_counter() - begin


def main(name: str) -> None:
    """Print."""
    scene: ge.Scene | None = None

    def load() -> None:
        nonlocal scene
        scene = ge.load(name)

    print(f"load {seconds(load):.3f} s")
    assert scene is not None
    loaded = scene
    print(f"first session of the process {seconds(lambda: loaded.session().close()):.3f} s (bar 0.6)")
    starts: list[float] = []
    memory: list[float] = []
    for _ in range(SESSIONS):
        begin = time.perf_counter()
        sim = loaded.session()
        starts.append(time.perf_counter() - begin)
        sim.run(0.5)
        sim.close()
        gc.collect()
        memory.append(resident_megabytes())
    print(f"a session {statistics.median(starts[1:]) * 1e3:.1f} ms, at most {max(starts[1:]) * 1e3:.1f} ms (bar 20)")
    print(f"{SESSIONS} sessions: {memory[-1] - memory[9]:+.1f} MB after the tenth (bar 5)")
    with loaded.session() as sim:
        sim.run(1.0)
        kept = [sim.checkpoint()]
        saves = [seconds(lambda: kept.append(sim.checkpoint())) for _ in range(20)]
        restores = [seconds(lambda: sim.restore(kept[0])) for _ in range(20)]
        tick = seconds(lambda: sim.step(600)) / 600
        save, restore = statistics.median(saves), statistics.median(restores)
        print(f"checkpoint {save * 1e3:.1f} ms, restore {restore * 1e3:.1f} ms; a tick {tick * 1e3:.3f} ms")


if __name__ == "__main__":
    main(*sys.argv[1:] or ["dd100_warehouse"])
