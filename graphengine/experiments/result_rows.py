"""Results files: one row a run, each a JSON object on a line of its own, in the order in which the runs ended."""

from __future__ import annotations

import fcntl
import json
import math
import platform
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from io import BufferedWriter
from pathlib import Path
from typing import Any

from graphengine.experiments.case_run import CaseResult
from graphengine.experiments.runs import Run
from graphengine.format.atomic_write import write_together
from graphengine.format.errors import UsageError
from graphengine.format.version import __version__

Row = dict[str, Any]
WALL = "wall"
"""Key of the wall time of a run, s: the only value in which the rows of equal runs differ."""

VERDICT = ("text", "place", "outcome", "robustness", "decided")
"""Keys of a verdict, which are those of `CheckResult`."""


def start_row(run: Run) -> Row:
    """Return the row of a run that has no result yet: an error without a reason."""
    return {
        "scenario": run.bundle.scenario.spec.scenario,
        "file": run.bundle.scenario.path.as_posix(),
        "case": run.case.name,
        "parameters": _plain(run.case.parameters),
        "seed": run.case.seed + run.number,
        "inputs": run.bundle.inputs,
        "outcome": "error",
        "reason": "",
        "verdicts": [],
        "metrics": {},
        "digest": "",
        "time": None,
        "versions": _versions(),
        WALL: None,
    }


def row_of(run: Run, result: CaseResult, wall: float) -> Row:
    """Return the row of a run; numbers that are not finite are null."""
    values = {name: getattr(result, name) for name in ("outcome", "metrics", "digest", "time")}
    verdicts = [{name: getattr(check, name) for name in VERDICT} for check in result.checks]
    more = {"reason": result.report(), "verdicts": verdicts, WALL: round(wall, 3)}
    return start_row(run) | {key: _plain(value) for key, value in (values | more).items()}


def identity(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the identity of a run, by which rows are sorted: file, case, seed, contents of the files, and versions."""
    return row["file"], row["case"], f"{row['seed']:020d}", row["inputs"], json.dumps(row["versions"], sort_keys=True)


def line(row: Row) -> bytes:
    """Return the line of a row."""
    return json.dumps(row, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a results file. A last line that was cut, as its writer was killed, is left out.

    Raises:
        UsageError: a line is not a row.
    """
    *lines, _ = path.read_bytes().split(b"\n")
    rows = []
    for number, text in enumerate(lines, 1):
        try:
            row = json.loads(text)
            identity(row)
        except (ValueError, KeyError, TypeError):
            raise UsageError(f"{path}:{number}: not a row of `graphrun test --results`") from None
        rows.append(row)
    return rows


def merged(files: Iterable[Sequence[Row]]) -> list[Row]:
    """Return the rows of several files, sorted; of the rows of one run, the last that is not an error."""
    found: dict[tuple[str, ...], Row] = {}
    for row in (row for rows in files for row in rows):
        before = found.get(identity(row))
        if before is None or row["outcome"] != "error" or before["outcome"] == "error":
            found[identity(row)] = row
    return [found[key] for key in sorted(found)]


class ResultsFile:
    """A results file to which rows are appended; a lock keeps other writers away.

    Args:
        path: the file.
        resume: whether the file may exist; its errors and a cut last line are then removed, as these runs are made again.

    Raises:
        UsageError: the file exists, or another process writes to it.
    """

    def __init__(self, path: Path, resume: bool) -> None:
        self._file = _locked(path)
        try:
            if path.stat().st_size and not resume:
                raise UsageError(f"{path}: exists; continue it with --resume, or remove it")
            kept = [row for row in read_rows(path) if row["outcome"] != "error"]
            content = b"".join(map(line, kept))
            if content != path.read_bytes():
                write_together({path: content})
                with self._file:
                    self._file = _locked(path)
        except BaseException:
            self._file.close()
            raise
        self.known = set(map(identity, kept))

    def add(self, row: Row) -> None:
        """Append a row at once."""
        self._file.write(line(row))
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _locked(path: Path) -> BufferedWriter:
    """Open a file for appending, so that no other process of this machine can open it so."""
    file = path.open("ab")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise UsageError(f"{path}: another process writes to this file") from None
    return file


def _plain(value: Any) -> Any:
    """Return a value as JSON has it, without numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@cache
def _versions() -> dict[str, str]:
    return {"graphengine": __version__, "mujoco": version("mujoco-core"), "python": platform.python_version()}
