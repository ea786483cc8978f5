"""What 40 ports as channels cost a tick: the same recorded scene with and without them, in turns in one run.

`python tests/bench/port_channels.py [SCENE] [ROUNDS]` prints the CPU time per tick of both, ms, and the median of the ratios of
neighbouring turns; a second recording without ports shows how far chance goes. Nothing is asserted.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import graphengine as ge

TICKS, PORTS = 60, 40


def main(scene: str, rounds: int) -> None:
    """Run and print."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        loaded = ge.load(scene)
        with loaded.session() as sim:
            chosen = [address for address, value in sim.values("*").items() if isinstance(value, float | tuple)][:PORTS]
        sides = {
            name: stack.enter_context(loaded.session(record=folder / f"{name}.mcap", ports=ports))
            for name, ports in (("without", ()), ("again", ()), ("with", tuple(chosen)))
        }
        times: dict[str, list[float]] = {name: [] for name in sides}
        names = list(sides)
        for turn in range(rounds + 2):
            for name in names[turn % 3 :] + names[: turn % 3]:
                start = time.process_time()
                sides[name].step(TICKS)
                times[name].append((time.process_time() - start) / TICKS * 1e3)
    base = times["without"][2:]
    print(f"{scene}: {statistics.median(base):.3f} ms a tick without ports, {len(chosen)} ports")
    for name in ("again", "with"):
        ratio = statistics.median(one / other for one, other in zip(times[name][2:], base, strict=True))
        print(f"{name:8}{statistics.median(times[name][2:]):.3f} ms a tick, {100 * (ratio - 1):+.1f} %")


if __name__ == "__main__":
    main((sys.argv[1:2] or ["dd100_warehouse"])[0], int((sys.argv[2:3] or ["30"])[0]))
