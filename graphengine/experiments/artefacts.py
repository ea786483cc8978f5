"""What a failed run leaves: a recording, one HTML file, a picture, a report, and the commands that show it again."""

from __future__ import annotations

import dataclasses
import math
import shlex
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.api.expectations.expectations import ExpectationCheck
from graphengine.api.run_page import RunPage
from graphengine.api.session import Session
from graphengine.experiments.case_run import CaseOptions, CaseResult, run_case
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import GraphError

if TYPE_CHECKING:
    from graphengine.experiments.scenario import Case, Scenario

RECORDING, PAGE, PICTURE, REPORT = "run.mcap", "run.html", "picture.png", "report.txt"


def run_and_keep(
    scenario: Scenario, case: Case, options: CaseOptions, folder: Path | None, *, run: int = 0
) -> CaseResult:
    """Run a case; if it does not pass, keep in a folder what shows why.

    Args:
        scenario: the scenario.
        case: one of its cases.
        options: how it is run.
        folder: folder of this case; None keeps nothing. The files of an earlier run are replaced.
        run: number of the run; runs after the first have a folder of their own.
    """
    if folder is None:
        return run_case(scenario, case, options, run=run)
    place = folder if run == 0 else folder.with_name(f"{folder.name}_run{run + 1}")
    for name in (PAGE, PICTURE, REPORT):
        (place / name).unlink(missing_ok=True)
    place.mkdir(parents=True, exist_ok=True)
    page = RunPage()

    def at_end(session: Session, checks: Sequence[ExpectationCheck]) -> None:
        _write_page(page, place, case.name, checks)
        with suppress(GraphError):  # no OpenGL on this machine
            session.picture(path=place / PICTURE)

    kept = dataclasses.replace(
        options, record=place / RECORDING, outputs=place, log=page.log, watch=page.watch, at_end=at_end
    )
    result = run_case(scenario, case, kept, run=run)
    if result.outcome in ("passed", "skipped"):
        shutil.rmtree(place)
    else:
        _write_report(place, result)
    return result


def _write_page(page: RunPage, place: Path, name: str, checks: Sequence[ExpectationCheck]) -> None:
    marks = [
        (check.verdict.decided, f"{check.outcome}: {check.expectation.text}")
        for check in checks
        if check.verdict.decided is not None
    ]
    for check in checks:
        finite = [(time, margin) for time, margin in check.trace or () if math.isfinite(margin)]
        if finite:
            times, margins = zip(*finite, strict=True)
            page.plot(f"margin of {check.expectation.text}", times, margins, least=0.0)
    page.write(place / PAGE, title=name, marks=sorted(marks))


def _write_report(place: Path, result: CaseResult) -> None:
    decided = [check.decided for check in result.checks if check.outcome == "failed" and check.decided is not None]
    recording = shlex.quote(str(place / RECORDING))
    lines = [f"{result.name}: {result.outcome}, seed {result.seed}", result.report(), ""]
    if (place / PAGE).exists():
        lines += ["open it in a browser, without a server:", f"  {place / PAGE}"]
    if (place / RECORDING).exists():
        at = min(decided, default=result.time)
        lines += ["replay it on the web page, from this time on:", f"  graphrun view {recording} --at {at:.3f}"]
        lines += ["replay it and compare each byte:", f"  graphrun replay {recording}"]
    write_together({place / REPORT: ("\n".join(lines) + "\n").encode()})
    result.kept = place / REPORT
