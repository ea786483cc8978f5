"""Runs the interop matrix against a sourced ROS 2 and writes docs/reference/interop.md.

python -m tests.interop.matrix            all columns, and the page
python -m tests.interop.matrix --print    the same, without writing the page
python -m tests.interop.matrix --only "dds rmw_fastrtps_cpp" "service server"
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from graphengine.format.atomic_write import write_together
from tests.interop.result import Result
from tests.waiting import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
_COLUMN = 1800.0
"""Seconds that a column may take."""


def run_cell(row: str, kind: str, rmw: str) -> Result:
    """Run one cell in this process, whose RMW_IMPLEMENTATION is that of the column."""
    from tests.interop.cells import ROWS
    from tests.interop.ends import CellError, UnreachableError, opened

    with tempfile.TemporaryDirectory() as folder, reserved_domain() as domain:
        try:
            with opened(kind, domain, Path(folder)) as cell:
                return Result(row, kind, rmw, True, ROWS[row](cell))
        except CellError as error:
            return Result(row, kind, rmw, False, str(error), isinstance(error, UnreachableError))
        except Exception as error:  # whatever happens in a cell, the others run
            return Result(row, kind, rmw, False, f"{type(error).__name__}: {error}")


def run_column(kind: str, rmw: str, rows: list[str]) -> list[Result]:
    """Run cells of a column in a process of their own, as rclpy has one RMW in a process."""
    command = [sys.executable, "-m", "tests.interop.matrix", "--column", kind, rmw, *rows]
    profiles = str(ROOT / "tests" / "ros" / "fast_dds.xml")
    environ = {**os.environ, "RMW_IMPLEMENTATION": rmw, "FASTRTPS_DEFAULT_PROFILES_FILE": profiles}
    done = subprocess.run(
        command, cwd=ROOT, env=environ, stdout=subprocess.PIPE, text=True, timeout=_COLUMN, check=True
    )
    return [Result(**json.loads(line)) for line in done.stdout.splitlines() if line.startswith("{")]


def run_all() -> list[Result]:
    """Run all cells, one after another."""
    from tests.interop.cells import COLUMNS, ROWS

    return [result for kind, rmw in COLUMNS for result in run_column(kind, rmw, list(ROWS))]


def missing() -> str:
    """Return what the matrix needs and is not installed; empty if nothing is missing."""
    for module in ("rclpy", "tf2_ros", "example_interfaces"):
        if importlib.util.find_spec(module) is None:
            return f"needs {module}"
    from tests.interop.page import packages

    absent = {"rmw_cyclonedds_cpp", "rmw_fastrtps_cpp"} - packages().keys()
    return f"needs {' and '.join(sorted(absent))}" if absent else ""


def main() -> int:
    """Run the matrix; return 0 if only cells fail that may, and all of those do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--print", action="store_true", help="do not write the page")
    parser.add_argument("--only", nargs="+", metavar=("COLUMN", "ROW"), help="run some cells and print their figures")
    parser.add_argument("--column", nargs="+", metavar=("KIND RMW", "ROW"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.column:
        kind, rmw, *rows = arguments.column
        for row in rows:
            print(json.dumps(asdict(run_cell(row, kind, rmw))), flush=True)  # noqa: T201
        return 0
    if why := missing():
        print(f"skipped: {why}", file=sys.stderr)  # noqa: T201
        return 0
    from tests.interop.cells import MAY_FAIL, ROWS
    from tests.interop.page import PAGE, render

    if arguments.only:
        column, *rows = arguments.only
        kind, rmw = column.split()
        results = run_column(kind, rmw, rows or list(ROWS))
    else:
        results = run_all()
        text = render(results)
        if not arguments.print:
            write_together({PAGE: text.encode()})
    for result in results:
        print(f"{'yes' if result.works else 'no '} {result.kind} {result.rmw} {result.row}: {result.text}")  # noqa: T201
    failed = {(result.row, result.kind, result.rmw) for result in results if not result.works}
    expected = {cell for cell in MAY_FAIL if cell in {(result.row, result.kind, result.rmw) for result in results}}
    return 0 if failed == expected else 1


if __name__ == "__main__":
    sys.exit(main())
