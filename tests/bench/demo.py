"""Ten drives of the scene `demo`, three minutes each, by `python -m tests.bench.demo`; figures are printed, none is asserted.

The seed sets the noise of the lidar and the pose from which the robot starts.
"""

from __future__ import annotations

import time

import graphengine as ge
from tests.api.demo_drive import Drive

SEEDS = 10
SECONDS = 180.0


def main() -> None:
    """Print a line for each seed."""
    scene = ge.load("demo")
    begin = time.perf_counter()
    for seed in range(SEEDS):
        with scene.session(seed=seed) as sim:
            drive = Drive(sim, seed)
            drive.run(SECONDS)
        touched = ", ".join(sorted(drive.contacts)) or "nothing"
        print(f"seed {seed}: {drive.rounds} rounds, {drive.length:.1f} m, touched {touched}", flush=True)
    print(f"{SEEDS * SECONDS:.0f} s of simulation in {time.perf_counter() - begin:.1f} s")


if __name__ == "__main__":
    main()
