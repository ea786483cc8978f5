"""What starting costs: `graphrun check` of one graph, as a ratio to importing numpy, pydantic and yaml, in CPU seconds.

Both run with their bytecode cached, in turns; the smallest of each counts.

    python -m tests.bench.start [GRAPH]
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROUNDS = 15
NEEDED = ("-c", "import numpy, pydantic, yaml")
EMPTY = ("-c", "pass")
FACE = ("-c", "import graphengine")


def seconds(arguments: tuple[str, ...], environment: dict[str, str]) -> float:
    """CPU time of one Python process, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], env=environment, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Print the ratio, and what importing the package adds to an empty Python."""
    graph = sys.argv[1] if len(sys.argv) > 1 else str(Path(__file__).parents[2] / "graphs/dd100/cmd_vel.yaml")
    check = ("-m", "graphengine.cli", "check", graph)
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": cache}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for arguments in (check, NEEDED):
            seconds(arguments, environment)
        rounds = [[seconds(one, environment) for one in (check, NEEDED, FACE, EMPTY)] for _ in range(ROUNDS)]
    checked, needed, face, empty = map(min, zip(*rounds, strict=True))
    print(f"check of {Path(graph).name}: {checked:.3f} s, numpy, pydantic and yaml: {needed:.3f} s")
    print(f"ratio {checked / needed:.2f}")
    print(f"import graphengine: {face - empty:.3f} s beyond Python")


if __name__ == "__main__":
    main()
