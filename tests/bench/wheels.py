"""What friction in two directions costs: physics steps of bases whose wheels have it, against the same with plain friction.

`python tests/bench/wheels.py` prints microseconds a step; nothing is asserted, because the machine is not ours alone. Steps of
both kinds take turns for the same reason.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

ROUNDS, STEPS = 200, 20


def simulation(folder: Path, robots: int, *, directed: bool) -> Simulation:
    """Mecanum bases side by side, which drive straight ahead."""
    keys = MECANUM_WHEELS
    if not directed:
        keys = f"materials:\n  all: {{dynamic_friction: 0.8, bind: [{', '.join(FOUR)}]}}\n"
    project = MECANUM.write(Project(folder), keys)
    fleet = "".join(f"  bot_{n}: {{use: bot.yaml, position: [0, {n}, {MECANUM.radius}]}}\n" for n in range(robots))
    made = project.write("scene.yaml", f"scene: bench\nworld: world.xml\nrobots:\n{fleet}").load().simulation
    for number in range(robots):
        selected = joints(made, f"bot_{number}").select([f"{name}_joint" for name in FOUR])
        selected.command(velocities=[4.0] * 4)
    steps(made, 240)
    return made


def step_times(simulations: list[Simulation]) -> list[float]:
    """Seconds a step of each, the least of some rounds."""
    taken: list[list[float]] = [[] for _ in simulations]
    for _ in range(ROUNDS):
        for one, times in zip(simulations, taken, strict=True):
            start = time.perf_counter()
            steps(one, STEPS)
            times.append((time.perf_counter() - start) / STEPS)
    return [min(times) for times in taken]


def main() -> None:
    """Print a line for each number of robots."""
    for robots in (1, 10, 50):
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
            plain, directed = step_times(
                [simulation(Path(one), robots, directed=False), simulation(Path(other), robots, directed=True)]
            )
        contacts = 4 * robots
        print(
            f"{robots:3} robots, {contacts:3} wheels: plain {plain * 1e6:7.1f} us a step, in two directions {directed * 1e6:7.1f}"
            f" ({(directed - plain) * 1e6:+.1f}, {directed / plain:.2f} times)",
            flush=True,
        )


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from graphengine.physics.simulation import Simulation  # noqa: E402 - after the path
from tests.physics.bases import FOUR, MECANUM, MECANUM_WHEELS, joints  # noqa: E402
from tests.physics.harness import Project, steps  # noqa: E402

if __name__ == "__main__":
    main()
