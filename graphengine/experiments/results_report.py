"""Summarises a results file: pass rates by parameter, and the worst runs with the commands that run them again."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence

from graphengine.experiments.result_rows import Row
from graphengine.experiments.statistics import wilson_interval
from graphengine.format.wording import printable, quoted

WORST = 10
"""Maximum number of runs to name."""


HEADS = ("scenario", "parameter", "value", "passed", "errors", "rate", "95 % interval")


def report(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of the report."""
    yield f"{len(rows)} runs: {counted(Counter(row['outcome'] for row in rows))}"
    table = [HEADS, *((*group, *_rate(counts)) for group, counts in _groups(rows).items())]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    yield from ("  ".join(map(str.ljust, cells, widths)).rstrip() for cells in table)
    for row in sorted((row for row in rows if row["outcome"] in ("failed", "error")), key=_badness)[:WORST]:
        again = f" ({row['rerun']})" if "rerun" in row else ""
        yield f"\n{row['outcome']}: {row['case']}, seed {row['seed']}{again}"
        yield from (f"  {printable(part)}" for part in row["reason"].splitlines())
        yield f"  {replay_command(row)}"


def counted(outcomes: Counter[str]) -> str:
    """Return the number of runs by outcome as text."""
    return ", ".join(f"{number} {outcome}" for outcome, number in sorted(outcomes.items()))


def replay_command(row: Row) -> str:
    """Return the command that runs the case of a row again and records the failure."""
    case = quoted(f"{row['file']}::{row['case']}")
    return f"graphrun test {case} --record-failures failures"


def margin(row: Row) -> float:
    """Return the smallest robustness of a run; infinity if no verdict has one."""
    return min(
        (verdict["robustness"] for verdict in row["verdicts"] if verdict["robustness"] is not None),
        default=float("inf"),
    )


def _badness(row: Row) -> tuple[bool, float, str, int]:
    """Return the key by which failed runs come before errors, and the least robust ones first."""
    return row["outcome"] == "error", margin(row), row["case"], row["seed"]


def _groups(rows: Iterable[Row]) -> dict[tuple[str, str, str], Counter[str]]:
    """Return the number of runs by outcome, for each scenario, and for each value of each of its parameters."""
    groups: defaultdict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
    for row in rows:
        groups[row["scenario"], "", ""][row["outcome"]] += 1
        for name, value in row["parameters"].items():
            groups[row["scenario"], name, printable(str(value))][row["outcome"]] += 1
    return dict(sorted(groups.items(), key=lambda group: group[0][:2]))


def _rate(counts: Counter[str]) -> tuple[str, str, str, str]:
    passed, judged = counts["passed"], counts["passed"] + counts["failed"]
    if not judged:
        return f"{passed}/{judged}", str(counts["error"]), "", ""
    low, high = wilson_interval(passed, judged)
    return f"{passed}/{judged}", str(counts["error"]), f"{passed / judged:.1%}", f"{low:.1%} to {high:.1%}"
