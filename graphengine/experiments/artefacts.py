"""What a failed run leaves: a recording, a picture, a report, and the commands that show it again."""

from __future__ import annotations

import dataclasses
import json
import math
import shlex
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.experiments.case_run import CaseOptions, CaseResult, run_case
from graphengine.format.atomic_write import write_text
from graphengine.format.errors import GraphError

if TYPE_CHECKING:
    from graphengine.experiments.scenario import Case, Scenario

RECORDING = "run.mcap"


def run_and_keep(scenario: Scenario, case: Case, options: CaseOptions, folder: Path | None, *, run: int = 0) -> CaseResult:
    """Run a case; if it fails, keep its recording and a report in a folder.

    Args:
        scenario: the scenario.
        case: one of its cases.
        options: how it is run.
        folder: folder of this case; None keeps nothing. A folder of an earlier run is replaced.
        run: number of the run; runs after the first have a folder of their own.
    """
    if folder is None:
        return run_case(scenario, case, options, run=run)
    place = folder if run == 0 else folder.with_name(f"{folder.name}_run{run + 1}")
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    kept = dataclasses.replace(options, record=place / RECORDING, outputs=place)
    result = run_case(scenario, case, kept, run=run)
    if result.outcome in ("passed", "skipped"):
        shutil.rmtree(place)
    else:
        _write_report(place, scenario, result)
    return result


def _write_report(place: Path, scenario: Scenario, result: CaseResult) -> None:
    decided = [check.decided for check in result.checks if check.outcome == "failed" and check.decided is not None]
    at = min(decided, default=result.time)
    recording = shlex.quote(str(place / RECORDING))
    lines = [f"{result.name}: {result.outcome}", "", result.report(), ""]
    lines += ["show it on the web page:", f"  graphrun view {recording} --at {at:.3f}"]
    lines += ["repeat it and compare each byte:", f"  graphrun replay {recording}", ""]
    write_text(place / "report.txt", "\n".join(lines))
    result.reason = "\n".join(filter(None, [result.reason, f"kept: {place / 'report.txt'}"]))
