"""What a matrix of runs costs: `python -m tests.bench.matrix` prints the figures of the guide on many runs.

The cost of the driver is that of runs that do nothing; the others are of a small scenario, the shipped `drives_straight`.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

from graphengine.experiments.matrix import make_rows
from graphengine.experiments.result_rows import Row, start_row
from graphengine.experiments.runs import Run, plan_runs
from graphengine.experiments.worker_process import RunSettings, Scenes
from graphengine.experiments.workers import Limits, ProcessPool
from tests.bench import matrix
from tests.experiments.falling import PASSES, write_scenario

NUMBERS = (100, 1_000, 10_000, 100_000)
SMALL = """format: 1
scenario: small
scene: dd100_flat
matrix: {seed: [SEEDS], DiffController.maxLinearSpeed: [0.6, 1.3]}
do:
  - publish: {topic: /dd100_0000/cmd_vel, message: {linear: {x: 1.3}}, every: 0.1s}
expect:
  - always: abs(pose("dd100").position[1]) < 0.02
  - within: 12s
    reach: pose("dd100").position[0] > 5
stop: {after: 12s}
"""


def stub(run: Run, settings: RunSettings, scenes: Scenes) -> Row:
    """Return the row of a run that was not made."""
    return start_row(run) | {"outcome": "passed", "time": 0.0, "wall": 0.0}


def driver_cost(folder: Path) -> None:
    """Print the time of the driver for each row, and its memory, by number of rows."""
    for number in NUMBERS:
        scenario = write_scenario(folder, range(number), [PASSES])
        begin = time.perf_counter()
        runs = plan_runs([str(scenario)], scripts=True)
        planned = time.perf_counter() - begin
        pool = ProcessPool(1, RunSettings(make=matrix.stub), Limits())
        path = folder / f"{number}.jsonl"
        before, used = time.perf_counter(), time.process_time()
        make_rows(runs, pool, path)
        wall, used = time.perf_counter() - before, time.process_time() - used
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
        size = path.stat().st_size / number
        begin = time.perf_counter()
        make_rows(runs, ProcessPool(1, RunSettings(), Limits()), path, resume=True)
        resumed = time.perf_counter() - begin
        print(
            f"{number:7d} rows: planned in {planned:.2f} s, made in {wall:.1f} s ({1e6 * used / number:.0f} us of the driver's "
            f"processor a row), resumed in {resumed:.1f} s, {size:.0f} bytes a row, driver's peak memory {peak:.0f} MB"
        )


def small_scenario(folder: Path, seeds: int) -> None:
    """Print the runs of a small scenario in an hour of a processor, and the memory of a worker."""
    scenario = folder / "small.scenario.yaml"
    scenario.write_text(SMALL.replace("SEEDS", ", ".join(map(str, range(seeds)))), encoding="utf-8")
    runs = plan_runs([str(scenario)])
    pool = ProcessPool(1, RunSettings(), Limits())
    warm = list(pool.rows(runs[:2]))
    begin = time.perf_counter()
    rows = list(pool.rows(runs[2:]))
    wall = time.perf_counter() - begin
    memory = pool.workers[0].memory
    pool.close()
    simulated = sum(row["time"] for row in rows)
    print(
        f"{len(rows)} runs of {simulated / len(rows):.1f} s of simulation in {wall:.1f} s: {3600 * len(rows) / wall:.0f} runs an "
        f"hour of one processor; the first run took {warm[0]['wall']:.1f} s; a worker has {memory / 1e6:.0f} MB"
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        small_scenario(Path(name), int(sys.argv[1]) if len(sys.argv) > 1 else 100)
        driver_cost(Path(name))
