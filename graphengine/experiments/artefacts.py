"""Files kept of a run that did not pass: a recording, one HTML file, a picture, and a report with commands that show it again."""

from __future__ import annotations

import dataclasses
import hashlib
import math
import os
import re
import shlex
import shutil
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.api.expectations.expectations import ExpectationCheck
from graphengine.api.run_page import RunPage
from graphengine.api.session import Session
from graphengine.experiments.case_run import CaseOptions, CaseResult, run_case
from graphengine.experiments.scenario import SUFFIX
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import GraphError

if TYPE_CHECKING:
    from graphengine.experiments.scenario import Case, Scenario

RECORDING, PAGE, PICTURE, REPORT = "run.mcap", "run.html", "picture.png", "report.txt"
LONGEST = 50
"""Maximum number of characters of a case in the name of its folder."""
_PLAIN = re.compile(rf"\w[\w.=+-]{{,{LONGEST - 1}}}")


def run_and_keep(
    scenario: Scenario, case: Case, options: CaseOptions, parent: Path | None, file: str, *, run: int = 0
) -> CaseResult:
    """Run a case; if it does not pass, write recording, page, picture and report to a folder of its own.

    Args:
        scenario: the scenario.
        case: one of its cases.
        options: how it is run.
        parent: folder in which the folder is made; None keeps nothing. The folder of an earlier run of the case
            is removed, also if this run passes.
        file: file of the scenario, relative to the folder of all tests.
        run: number of the run; each run has a folder of its own.
    """
    if parent is None:
        return run_case(scenario, case, options, run=run)
    try:
        parent.mkdir(parents=True, exist_ok=True)
        making = tempfile.TemporaryDirectory(prefix=".unfinished-", dir=parent)
    except OSError as error:
        reason = f"--record-failures {parent}: {error.strerror}"
        return CaseResult(case.name, case.parameters, case.seed + run, reason=reason)
    with making:
        made, place = Path(making.name, "files"), artefact_folder(parent, file, case, run)
        made.mkdir()
        result = _run(scenario, case, options, made, run)
        if place.exists():
            shutil.rmtree(place)
        if result.outcome not in ("passed", "skipped"):
            made.rename(place)
            _write_report(place, result)
    return result


def artefact_folder(parent: Path, file: str, case: Case, run: int) -> Path:
    """Return the folder of a run: named as its case, with a digest if other runs or files of the user may have this name."""
    name, plain = case.name, parent / case.name
    if run == 0 and file == f"{name}{SUFFIX}" and _PLAIN.fullmatch(name) and _is_ours(plain, name):
        return plain
    label = re.sub(r"[^\w.=+-]+", "_", name)[:LONGEST] + (f"_run{run + 1}" if run else "")
    identity = repr((file, name, dict(case.parameters), run)).encode()
    return parent / f"{label}~{hashlib.blake2b(identity, digest_size=5).hexdigest()}"


def _is_ours(place: Path, case: str) -> bool:
    """Return whether a folder does not exist, or is that of an earlier run."""
    if not os.path.lexists(place):
        return True
    report = place / REPORT
    return not place.is_symlink() and report.is_file() and report.read_bytes().startswith(f"{case}: ".encode())


def _run(scenario: Scenario, case: Case, options: CaseOptions, folder: Path, run: int) -> CaseResult:
    page = RunPage()

    def at_end(session: Session, checks: Sequence[ExpectationCheck]) -> None:
        _write_page(page, folder, case.name, checks)
        with suppress(GraphError):  # no OpenGL on this machine
            session.picture(path=folder / PICTURE)

    kept = dataclasses.replace(
        options, record=folder / RECORDING, outputs=folder, log=page.log, watch=page.watch, at_end=at_end
    )
    return run_case(scenario, case, kept, run=run)


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
