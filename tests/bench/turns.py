"""Compares what a tick costs in several sessions that run in turns of half a second in one process."""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Callable, Mapping

TICKS = 30
"""Ticks of a turn."""
WARM = 2
"""Rounds of turns that do not count."""


def compare(title: str, sides: Mapping[str, Callable[[int], object]], rounds: int) -> None:
    """Print the CPU time of a tick of the first side, and for each other side the median of the ratios of neighbouring turns.

    Args:
        title: begin of the first line.
        sides: functions that run a number of ticks, by name.
        rounds: number of turns of each side.
    """
    times: dict[str, list[float]] = {name: [] for name in sides}
    for turn in range(rounds + WARM):
        first = turn % len(sides)
        for name, run in itertools.islice(itertools.cycle(sides.items()), first, first + len(sides)):
            start = time.process_time()
            run(TICKS)
            times[name].append((time.process_time() - start) / TICKS * 1e3)
    base, *others = (values[WARM:] for values in times.values())
    print(f"{title}: {statistics.median(base):.3f} ms a tick {next(iter(sides))}")
    for name, values in zip(itertools.islice(sides, 1, None), others, strict=True):
        ratio = statistics.median(one / other for one, other in zip(values, base, strict=True))
        print(f"{name:12}{statistics.median(values):.3f} ms a tick, {100 * (ratio - 1):+.1f} %")
