"""Makes the runs of scenarios in processes or on a cluster, and appends their rows to a results file."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Protocol

from graphengine.experiments.result_rows import ResultsFile, Row, identity, start_row
from graphengine.experiments.runs import Run

SHOWN = 20
"""Maximum number of failed runs and errors to print one by one."""
PROGRESS = 30.0
"""Time between two lines about the number of runs so far, s."""


class Pool(Protocol):
    """Executes runs."""

    def rows(self, runs: Iterable[Run]) -> Iterator[Row]:
        """Make runs; yield their rows in the order in which they end."""

    def close(self) -> None:
        """Stop the workers."""


def make_rows(runs: Sequence[Run], pool: Pool, path: Path, *, resume: bool = False) -> Counter[str]:
    """Make runs and append their rows to a results file; return the number of rows by outcome.

    Args:
        runs: the runs; of equal runs, one is made.
        pool: makes the runs; it is closed at the end.
        path: the results file.
        resume: whether the file may exist; runs that it has are not made again, except for errors.

    Raises:
        UsageError: the file exists, another process writes to it, or it is not a results file.
    """
    counts, due = Counter[str](), time.monotonic() + PROGRESS
    with closing(pool), closing(ResultsFile(path, resume)) as results:
        missing = {key: run for run in runs if (key := identity(start_row(run))) not in results.known}
        for row in pool.rows(missing.values()):
            results.add(row)
            counts[row["outcome"]] += 1
            if time.monotonic() > due:
                due += PROGRESS
                say(f"{counts.total()} of {len(missing)} runs")
            if row["outcome"] in ("failed", "error") and counts["failed"] + counts["error"] <= SHOWN:
                reason = row["reason"].partition("\n")[0]
                again = f" ({row['rerun']})" if "rerun" in row else ""
                say(f"{row['outcome']}: {row['case']}, seed {row['seed']}{again}: {reason}")
    return counts


def say(text: str) -> None:
    """Write a line to stderr."""
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()
