"""`graphrun test`: run scenarios and Python tests with pytest."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

from graphengine.experiments.scenario_options import add_scenario_options
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError
from graphengine.format.interrupts import by_sigterm

HELP = "run scenarios (*.scenario.yaml) and Python tests with pytest"
_REWRITTEN = "Module already imported so cannot be rewritten; graphengine"
"""Warning of pytest about this package, which has no assertions that pytest would rewrite."""
_CODES = (
    "Exit codes are those of pytest: 0 all passed; 1 some failed or could not be run; 2 interrupted, or a file has errors; "
    "3 internal error; 4 wrong arguments; 5 no test found."
)
WORDS = ("show", "merge")
"""First words of a command line that reads results files, which follow; `show` without such files is a folder of this name."""
SUFFIX = ".jsonl"
WRONG_USAGE = 4


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun test` to its parser."""
    words = (
        f"; `show ROWS{SUFFIX} ...` and `merge ROWS{SUFFIX} ... -o FILE` read results (without {SUFFIX} files, folders)"
    )
    where = "files, folders, or FILE::CASE (default: the current folder)"
    parser.add_argument("paths", metavar="PATH", nargs="*", help=where + words)
    parser.add_argument("-n", metavar="N", dest="processes", help="number of processes, or auto")
    add_scenario_options(parser.add_argument)
    parser.add_argument(
        "-k", metavar="EXPRESSION", dest="keyword", help="run only tests whose names match, as for pytest"
    )
    parser.add_argument("--junit", metavar="FILE", type=Path, help="write the results as JUnit XML")
    scripts = "let graphs run the Python code of their ScriptNodes"
    parser.add_argument("--allow-scripts", action="store_true", help=scripts)
    parser.add_argument("--collect-only", action="store_true", help="check the files and list the cases; run nothing")
    parser.add_argument(
        "--schema", action="store_true", help="print the JSON Schema of scenario files, for editors; run nothing"
    )
    rows = parser.add_argument_group("many runs", "Without pytest: only scenarios, one row a run in a results file.")
    written = "append a JSON row for each run to this file"
    rows.add_argument("--results", metavar=f"ROWS{SUFFIX}", type=Path, help=written)
    known = "make only the runs that the results file does not have, and those that ended with an error"
    rows.add_argument("--resume", action="store_true", help=known)
    limit = "wall time after which a run is ended as an error (default: 600)"
    rows.add_argument("--time-limit", metavar="SECONDS", type=float, default=600.0, help=limit)
    memory = "memory of a process above which its run is ended as an error (default: the machine's, divided by N)"
    rows.add_argument("--memory-limit", metavar="MB", type=float, help=memory)
    digest = "let nodes publish on all topics, as for a recording, so that the digest of a row covers them"
    rows.add_argument("--digest-all", action="store_true", help=digest)
    workers = "make the runs on a Ray cluster: ray starts one on this machine, ray:ADDRESS or ray:auto joins one"
    rows.add_argument("--workers", metavar="ray[:ADDRESS]", help=workers)
    rows.add_argument("-o", "--output", metavar="FILE", type=Path, help="with merge: the file to write")
    parser.epilog = _CODES
    parser.set_defaults(wrong_usage=WRONG_USAGE)


def reads_results(paths: list[str]) -> bool:
    """Return whether the arguments are `show` or `merge` and results files."""
    return len(paths) > 1 and paths[0] in WORDS and all(path.endswith(SUFFIX) for path in paths[1:])


def execute(arguments: argparse.Namespace) -> int:
    """Run the tests, or show or merge their results; return the exit code of pytest.

    Raises:
        UsageError: pytest is not installed, or arguments do not belong together.
    """
    if arguments.schema:
        import json

        from graphengine.experiments.scenario import ScenarioSpec

        print(json.dumps(ScenarioSpec.model_json_schema(), indent=2))
        return 0
    unfit = [option for option in ("results", "rerun", "record_failures") if getattr(arguments, option)]
    if arguments.bag is not None and unfit:
        raise UsageError(f"--{unfit[0].replace('_', '-')}: not with --bag, which simulates nothing")
    if reads_results(arguments.paths):
        from graphengine.experiments.results_commands import read_results

        return read_results(arguments)
    with by_sigterm():  # so that started programs end
        return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    if arguments.results is not None:
        from graphengine.experiments.results_commands import make_results

        return make_results(arguments)
    for option in ("resume", "memory_limit", "digest_all", "workers", "output"):
        if getattr(arguments, option):
            name = option.replace("_", "-")
            raise UsageError(f"--{name}: only {'with merge' if option == 'output' else 'with --results'}")
    return _run_pytest(arguments)


def _run_pytest(arguments: argparse.Namespace) -> int:
    try:
        import pytest
    except ImportError:
        raise UsageError(f"graphrun test needs pytest; install it with: {install_command('pytest')}") from None
    if arguments.processes is not None and find_spec("xdist") is None:
        raise UsageError(f"-n needs pytest-xdist; install it with: {install_command('pytest')}")
    given = [*arguments.paths, "-W", f"ignore:{_REWRITTEN}:pytest.PytestAssertRewriteWarning"]
    for option, value in (
        ("-n", arguments.processes),
        ("-k", arguments.keyword),
        ("--junitxml", arguments.junit),
        ("--bag", arguments.bag),
        ("--record-failures", arguments.record_failures),
        ("--shard", arguments.shard),
        ("--rerun", arguments.rerun),
    ):
        given += [option, str(value)] if value is not None else []
    given += ["--allow-programs"] if arguments.allow_programs else []
    given += ["--allow-scenario-scripts"] if arguments.allow_scripts else []
    given += ["--collect-only", "-q"] if arguments.collect_only else []
    return int(pytest.main(given))
