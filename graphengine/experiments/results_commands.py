"""The commands of `graphrun test` that write and read results files."""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from graphengine.experiments.matrix import Pool, make_rows, say
from graphengine.experiments.result_rows import Row, identity, line, merged, read_rows, start_row
from graphengine.experiments.results_report import counted, report
from graphengine.experiments.runs import NO_CASES, Run, plan_runs, shard
from graphengine.experiments.worker_process import RunSettings
from graphengine.experiments.workers import Limits, ProcessPool
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import UsageError

PASSED, FAILED, STOPPED, EMPTY = 0, 1, 2, 5
"""Exit codes, which are those of pytest."""
RAY = "ray"
PYTEST_ONLY = {"keyword": "-k", "junit": "--junit", "record_failures": "--record-failures", "bag": "--bag"}


def make_results(arguments: argparse.Namespace) -> int:
    """Make the runs of scenarios and append their rows to a results file; return the exit code.

    Raises:
        UsageError: arguments do not belong together, or the results file cannot be used.
    """
    for option, name in PYTEST_ONLY.items():
        if getattr(arguments, option):
            remedy = "name cases as FILE::CASE; `graphrun test show` prints the commands that run failed cases again"
            raise UsageError(f"{name}: not with --results\n  {remedy}")
    try:
        planned = plan_runs(arguments.paths or ["."], scripts=arguments.allow_scripts)
    except CheckError as error:
        say("\n".join(finding.render() for finding in error.findings))
        return STOPPED
    runs = shard(planned, arguments.shard)
    if planned and not runs:
        say(NO_CASES.format(arguments.shard))
    if arguments.collect_only:
        sys.stdout.writelines(f"{run.bundle.scenario.path}::{run.case.name}\n" for run in runs)
        return PASSED if planned else EMPTY
    try:
        counts = make_rows(runs, _pool(arguments), arguments.results, resume=arguments.resume)
    except KeyboardInterrupt:
        say(f"interrupted; continue with --results {arguments.results} --resume")
        return STOPPED
    say(f"{len(runs)} runs: {counted(counts) or 'nothing left to do'}; see graphrun test show {arguments.results}")
    return EMPTY if not planned else FAILED if _missed(runs, read_rows(arguments.results)) else PASSED


def read_results(arguments: argparse.Namespace) -> int:
    """Merge results files, or print their summary; return the exit code.

    Raises:
        UsageError: a file is not a results file, or `merge` has no output.
    """
    word, *names = arguments.paths
    missing = [name for name in names if not os.path.isfile(name)]
    if missing:
        raise UsageError(f"{missing[0]}: no such file")
    rows = merged(read_rows(Path(name)) for name in names)
    if word == "show":
        sys.stdout.writelines(f"{text}\n" for text in report(rows))
    elif arguments.output is None:
        raise UsageError("merge: give the file to write with -o FILE")
    else:
        write_together({arguments.output: b"".join(map(line, rows))})
    return PASSED


def _missed(runs: Sequence[Run], rows: Sequence[Row]) -> bool:
    """Return whether one of the runs was an error, or more runs of a case failed than its scenario allows by `pass`."""
    known = {identity(start_row(run)): run for run in runs}
    made = [(known[key], row["outcome"]) for row in rows if (key := identity(row)) in known]
    failures = Counter((run.bundle.scenario, run.case.name) for run, outcome in made if outcome == "failed")
    excess = (
        number - scenario.spec.runs + (scenario.spec.pass_ or scenario.spec.runs)
        for (scenario, _), number in failures.items()
    )
    return any(outcome == "error" for _, outcome in made) or max(excess, default=0) > 0


def _pool(arguments: argparse.Namespace) -> Pool:
    given = arguments.processes or "1"
    if given != "auto" and not (given.isdecimal() and int(given)):
        raise UsageError(f"-n {given}: expected a number of at least 1, or auto")
    number = len(os.sched_getaffinity(0)) if given == "auto" else int(given)
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    memory = machine / number if arguments.memory_limit is None else arguments.memory_limit * 1e6
    limits = Limits(arguments.time_limit, memory, arguments.rerun or 1)
    settings = RunSettings(arguments.allow_programs, arguments.allow_scripts, arguments.digest_all)
    if arguments.workers is None:
        return ProcessPool(number, settings, limits)
    kind, _, address = arguments.workers.partition(":")
    if kind != RAY:
        raise UsageError(f"--workers {arguments.workers}: expected ray, ray:auto or ray:ADDRESS")
    from graphengine.experiments.ray_pool import RayPool

    return RayPool(address, settings, limits)
