"""`graphrun test`: run scenarios and Python tests with pytest."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from graphengine.experiments.scenario import ScenarioSpec
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError

HELP = "run scenarios (*.scenario.yaml) and Python tests with pytest"
_CODES = (
    "Exit codes are those of pytest: 0 all passed; 1 some failed or could not be run; 2 interrupted, or a file has errors; "
    "3 internal error; 4 wrong arguments; 5 no test found."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun test` to its parser."""
    parser.add_argument("paths", metavar="PATH", nargs="*", help="files or folders (default: the current folder)")
    parser.add_argument("-n", metavar="N", dest="processes", help="number of processes, or auto")
    parser.add_argument(
        "-k", metavar="EXPRESSION", dest="keyword", help="run only tests whose names match, as for pytest"
    )
    parser.add_argument("--junit", metavar="FILE", type=Path, help="write the results as JUnit XML")
    bag = "judge the expectations over the topics of this recording, of a robot or a simulator; nothing is simulated"
    parser.add_argument("--bag", metavar="FILE", type=Path, help=bag)
    kept = "keep a recording, an HTML page, a picture and a report of each run that does not pass in this folder"
    parser.add_argument("--record-failures", metavar="DIR", type=Path, help=kept)
    parser.add_argument("--allow-programs", action="store_true", help="let scenarios start programs (`start:`)")
    parser.add_argument("--collect-only", action="store_true", help="check the files and list the cases; run nothing")
    parser.add_argument(
        "--schema", action="store_true", help="print the JSON Schema of scenario files, for editors; run nothing"
    )
    parser.epilog = _CODES


def execute(arguments: argparse.Namespace) -> int:
    """Run the tests; return the exit code of pytest.

    Raises:
        UsageError: pytest is not installed.
    """
    if arguments.schema:
        print(json.dumps(ScenarioSpec.model_json_schema(), indent=2))
        return 0
    try:
        import pytest
    except ImportError:
        raise UsageError(f"graphrun test needs pytest; install it with: {install_command('pytest')}") from None
    given = [*arguments.paths]
    for option, value in (
        ("-n", arguments.processes),
        ("-k", arguments.keyword),
        ("--junitxml", arguments.junit),
        ("--bag", arguments.bag),
        ("--record-failures", arguments.record_failures),
    ):
        given += [option, str(value)] if value is not None else []
    given += ["--allow-programs"] if arguments.allow_programs else []
    given += ["--collect-only", "-q"] if arguments.collect_only else []
    return int(pytest.main(given))
