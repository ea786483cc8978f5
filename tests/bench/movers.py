"""What four movers cost a tick: the same scene with and without them, in turns of half a second in one run.

`python tests/bench/movers.py [SCENE] [ROUNDS]` prints the milliseconds a tick of both, and the median of the ratios of
neighbouring turns; a second pair of scenes without movers shows how far chance goes. Nothing is asserted.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack

from graphengine.format.files import find_file
from tests.bench.record import Side
from tests.bench.turns import compare

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
        files = {"without movers": path, "again": path, "with": crowded}
        compare(path.stem, {name: Side(str(file), None, stack).run for name, file in files.items()}, rounds)


if __name__ == "__main__":
    main((sys.argv[1:2] or ["dd100_warehouse"])[0], int((sys.argv[2:3] or ["60"])[0]))
