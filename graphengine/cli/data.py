"""`graphrun data`: write topics and ports of a recording as a table."""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphengine.api.value_table import ValueTable
    from graphengine.cli.recorded_run import RecordedRun

EXAMPLES = """examples:
  graphrun data run.mcap --topics /odom -o odom.csv
  graphrun data run.mcap --topics /odom.pose.pose.position '/*/scan.ranges'
  graphrun data run.mcap --ports '*/ComputeOdom.*' -o ports.parquet

One column has the times, s; each number or text of a message has a column of its
own, such as /odom.pose.pose.position.x, and each element of an array, such as
/scan.ranges[0]. Arrays of more than 5000 elements are left out. A row has the
values of one time; the value of a port stands in all rows until it changes.
Ports that the recording does not contain are computed by a replay."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun data` to its parser."""
    from graphengine.cli.common import add_access_arguments

    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = EXAMPLES
    bag = (
        "recording of `graphrun run --record`; for topics, any bag: an .mcap or .db3 file, or a folder with such files"
    )
    parser.add_argument("recording", metavar="FILE", type=Path, help=bag)
    topics = "topics, or fields of topics, as in /odom.pose.pose; names may be globs"
    parser.add_argument("--topics", metavar="TOPIC", nargs="+", default=[], help=topics)
    ports = "ports, [ROBOT/][GRAPH/]NODE.PORT; their parts may be globs, as in '*/ComputeOdom.*'"
    parser.add_argument("--ports", metavar="ADDRESS", nargs="+", default=[], help=ports)
    output = "file to write: CSV, or Parquet if its name ends in .parquet (default: CSV to standard output)"
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, help=output)
    add_access_arguments(parser)
    parser.set_defaults(against=None, set=[], seed=None, rays=None)


def execute(arguments: argparse.Namespace) -> int:
    """Write the table; return 0, or 1 if the recorded scene has errors.

    Raises:
        RecordingError: the recording cannot be read.
        UsageError: the recording has no such topic or port, or the name of the file to write has a wrong suffix.
    """
    from graphengine.api.recorded_values import add_recorded, has_ports
    from graphengine.api.value_table import ValueTable
    from graphengine.cli.common import check_suffix
    from graphengine.cli.recorded_run import start_recorded_run
    from graphengine.format.errors import UsageError

    if arguments.output is not None:
        check_suffix(arguments.output, ".csv", ".parquet")
    if not (arguments.topics or arguments.ports):
        raise UsageError("choose topics with --topics, or ports with --ports")
    with closing(ValueTable()) as table:
        if has_ports(arguments.recording, arguments.ports):
            add_recorded(table, arguments.recording, arguments.topics, arguments.ports)
        elif code := start_recorded_run(arguments, lambda run: _replay(arguments, run, table)):
            return code
        return _write(arguments, table)


def _replay(arguments: argparse.Namespace, run: RecordedRun, table: ValueTable) -> int:
    from graphengine.api.recorded_values import add_replayed
    from graphengine.cli.progress import progress
    from graphengine.recording.replay import Replay

    replay = Replay(run.runner.session, run.runner.network, run.recording, warn=run.warn)
    with progress("replaying", lambda: run.recording.share_read, 1.0):
        add_replayed(table, replay, arguments.topics, arguments.ports)
    return 0


def _write(arguments: argparse.Namespace, table: ValueTable) -> int:
    from graphengine.cli.common import clean, counted
    from graphengine.format.files import near

    for name, elements in table.omitted.items():
        print(clean(f"left out: {name} has {elements} elements"), file=sys.stderr)
    if arguments.output is None:
        sys.stdout.writelines(table.csv())
        return 0
    table.write(arguments.output)
    print(
        clean(f"{near(str(arguments.output))}: {counted(len(table.columns), 'column')} and the time"), file=sys.stderr
    )
    return 0
