"""What four movers cost a tick: the same scene with and without them, in turns of half a second in one run.

`python tests/bench/movers.py [SCENE] [ROUNDS]` prints the milliseconds a tick of both, and the median of the ratios of
neighbouring turns; a second pair of scenes without movers shows how far chance goes. Nothing is asserted.
"""

from __future__ import annotations

import itertools
import statistics
import sys
import time
from contextlib import ExitStack
from pathlib import Path

from graphengine.format.files import find_file
from tests.bench.record import Side

TICKS = 30
"""Ticks of a turn."""
MOVERS = """
movers:
  one: {shape: person, path: [[-1.5, 3], [-1.5, 9]], speed: 1.2, loop: true}
  two: {shape: person, path: [[-1, 2], {at: [-6, 2], pause: 1s}], speed: 1.0, loop: there_and_back}
  three: {shape: person, path: [[-7, 3], [-7, 9], [-6.5, 9]], speed: 0.8, loop: true}
  four: {shape: person, path: [[-7, 10], [-2, 10]], speed: 1.5, loop: there_and_back}
"""


def main(scene: str, rounds: int) -> None:
    """Run and print."""
    path = find_file(scene)
    crowded = path.with_name("crowded.yaml")
    with ExitStack() as stack:
        crowded.write_text(path.read_text(encoding="utf-8") + MOVERS, encoding="utf-8")
        stack.callback(crowded.unlink)
        sides = {
            name: Side(str(file), None, stack) for name, file in (("without", path), ("again", path), ("with", crowded))
        }
        times: dict[str, list[float]] = {name: [] for name in sides}
        for turn in range(rounds + 2):
            for name, side in itertools.islice(itertools.cycle(sides.items()), turn % 3, turn % 3 + 3):
                start = time.process_time()
                side.run(TICKS)
                times[name].append((time.process_time() - start) / TICKS * 1e3)
    base = times["without"][2:]
    print(f"{Path(scene).stem}: {statistics.median(base):.3f} ms a tick without movers")
    for name in ("again", "with"):
        ratio = statistics.median(one / other for one, other in zip(times[name][2:], base, strict=True))
        print(f"{name:8}{statistics.median(times[name][2:]):.3f} ms a tick, {100 * (ratio - 1):+.1f} %")


if __name__ == "__main__":
    main((sys.argv[1:2] or ["dd100_warehouse"])[0], int((sys.argv[2:3] or ["60"])[0]))
