"""The command `graphrun`: one module per verb. Heavy modules are imported only when a verb runs."""

from __future__ import annotations

from graphengine.format import interrupts

if interrupts.is_program():
    interrupts.begin()  # before the imports below, which take most of the time until `main`

import argparse
import atexit
import contextlib
import gc
import importlib
import io
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from graphengine.cli.options import add_flag
from graphengine.cli.parser import Parser, add_verb
from graphengine.format.version import __version__

VERBS = {
    "demo": "run a demo in which a robot drives through a warehouse, and print commands to try",
    "new": "create a project folder with a robot, its graphs, a scene and a test",
    "run": "run a scene or a graph",
    "ctl": "control a running simulation: pause, step, reset, spawn, push",
    "replay": "replay a recorded run and compare the output byte by byte",
    "view": "show a recorded run on a web page: play it, go to any time, find the first difference of a replay",
    "data": "write topics and ports of a recording as a table: CSV or Parquet",
    "check": "report all errors and warnings in scenes and graphs",
    "explain": "explain the code of an error, warning or note: its cause, an example and the remedy",
    "show": "print a graph's nodes and wires, its schedule or its generated code, or draw the graph",
    "snapshot": "render an image or a video of a scene or a recording, from above, behind a robot or from a camera",
    "calibrate": "drive a robot on a flat floor and measure its speeds, drift, odometry errors and effective wheel radius",
    "map": "make an occupancy map of a scene for nav2's map_server",
    "import": "convert the ActionGraphs of an Isaac Sim script or USD stage to YAML files",
    "export": "convert a graph to a Python script that builds it in Isaac Sim",
    "import-robot": "make a robot file from a URDF, xacro, SDF, MJCF or USD file, or from a running ROS 2 system",
    "topics": "list the topics, services and actions of a scene without running it: types, QoS, frames, rates",
    "robots": "list the robots of a scene with their robot_state_publisher topics, or print the URDF of a robot",
    "topic": "inspect topics on a live network, with or without ROS installed: list, info, echo, hz, delay, pub",
    "service": "list and call services on a live network, with or without ROS installed: list, type, call",
    "action": "list actions and send goals on a live network, with or without ROS installed: list, info, send_goal",
    "node": "inspect nodes on a live network, with or without ROS installed: list, info",
    "param": "read and set parameters on a live network, with or without ROS installed: list, get, set, describe, dump, load",
    "tf": "print the tf frame tree of a live network",
    "nav2": "drive the robots of a scene with Nav2: write Nav2's files, send goals and measure how well robots reach them",
    "teleop": "drive a robot from the keyboard",
    "nodes": "list or search node types, or print the ports of one",
    "doctor": "check this installation, this machine and its network for problems, and print a remedy for each",
    "completion": "print the script for tab completion of graphrun in bash, zsh or fish",
    "schema": "print the JSON Schema of graph, scene or robot files, for editors",
}

FILES_ONLY = ("check", "completion", "explain", "nodes", "schema", "show")
"""Verbs that exchange no data with other programs. They do not import `logging`, so that they start fast."""

MODULES = {"import": "import_graph", "import-robot": "import_urdf"}
"""A dict from a verb to the name of its module, for modules that are not named after their verb."""
OLD_NAMES = {"import-urdf": "import-robot"}
"""A dict from former names of verbs to their current names; former names still work."""


class Version(argparse.Action):
    """The option `--version`, which with `--verbose` also prints sandbox features, transports and damage to the installation."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print the version and exit with code 0; with `--verbose`, also print the sandbox features and transports."""
        print(f"graphrun {__version__}")
        if parser.get_default("verbose"):
            from graphengine.cli.common import clean
            from graphengine.format.installed_files import conflicts
            from graphengine.ros.transports.select import transport_states
            from graphengine.sandbox.borders import describe

            print(f"confinement: {describe()}")
            for name, state in transport_states().items():
                print(f"transport {name}:", clean(state.replace("\n", "\n  ")))
            found, remedies = conflicts()
            for conflict in found:
                print("installation:", clean(conflict))
            for remedy in remedies:
                print(f"  {remedy}")
        parser.exit()


def make_parser(*whole: str, plugin: str | None = None) -> argparse.ArgumentParser:
    """Return the parser of the command line with all built-in verbs; only the verbs in `whole` get their arguments.

    Unless `plugin` is None, the parser also has the verbs of installed packages; only the verb `plugin` gets its arguments, or
    every verb if `plugin` is empty.
    """
    parser = Parser(
        prog="graphrun",
        description="Simulate ROS 2 robots with MuJoCo; graphs of nodes, written in YAML, control them.",
    )
    parser.add_argument("--version", action=Version, nargs=0, help="show the version and exit")
    add_flag(parser, "--verbose", "with --version: also show which sandbox features and transports can be used")
    add_flag(parser, "--all", "with --help: also list the verbs of installed packages")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, summary in VERBS.items():
        sub = add_verb(verbs, name, summary)
        if name in whole:
            module = importlib.import_module(f"graphengine.cli.{MODULES.get(name, name).replace('-', '_')}")
            module.add_arguments(sub)
            if hasattr(module, "execute"):  # otherwise each of its subverbs has a function
                sub.set_defaults(function=module.execute)
    if plugin is not None:
        from graphengine.cli.plugin_verbs import add_plugin_verbs

        add_plugin_verbs(parser, verbs, plugin, OLD_NAMES)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `graphrun` with the given arguments; None takes the arguments of the command line.

    Returns:
        The exit code. 0: success, also if Ctrl-C ended a run; 1: errors in files or in the run; 2: invalid command line;
        3: out of memory; 130: Ctrl-C before a run began or before there was a result.
    """
    if arguments is None:  # called by `graphrun`, not by a test or another program in its own process
        gc.set_threshold(10_000)  # collections at the default take a sixth of the start, and free almost nothing
        atexit.register(gc.freeze)  # the collection at exit takes up to a second after a run, and frees nothing of use
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        verb = next((index for index, word in enumerate(given) if not word.startswith("-")), None)
        if verb is not None:
            given[verb] = OLD_NAMES.get(given[verb], given[verb])
        name = "" if verb is None else given[verb]
        parser = make_parser(name, plugin=name if name not in VERBS and (name or "--all" in given) else None)
        parser.set_defaults(verbose="--verbose" in given)
        parsed = parser.parse_args(given)
        if arguments is None:
            interrupts.work()  # not for --help, as it imports more; within the block that catches an interrupt
        code = _execute(parsed)
        if arguments is None:
            _discard_unwritten()
        return code
    except BaseException as error:
        if interrupts.has_cause(error, KeyboardInterrupt):
            # The interpreter would wait for threads, which an interrupt may have left without an end.
            if arguments is None:
                interrupts.finish()
                atexit._run_exitfuncs()
                interrupts.end(interrupts.CODE)
            return interrupts.CODE
        if not interrupts.has_cause(error, MemoryError) and str(error) != "can't start new thread":
            raise
        from graphengine.cli.common import clean

        print(clean(": ".join(("error: out of memory", *filter(None, [str(error)])))), file=sys.stderr, flush=True)
        if arguments is None:
            interrupts.end(interrupts.OUT_OF_MEMORY)  # closing the interpreter needs memory too
        return interrupts.OUT_OF_MEMORY
    finally:
        interrupts.finish()


def _discard_unwritten() -> None:
    """Discard output that cannot be written; some versions of Python would write it again at exit, and exit with code 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):  # a full disk, a reader that is gone, or a closed stream
            with contextlib.suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _execute(parsed: argparse.Namespace) -> int:
    """Execute the verb and return its exit code; print the message of an exception and return the exit code for it."""
    from graphengine.cli.common import clean, explain, print_findings
    from graphengine.cli.terminal import wrapped
    from graphengine.format.diagnostics import CheckError
    from graphengine.format.errors import GraphError, UsageError
    from graphengine.format.process_limits import SMALLEST, has_address_space

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr has it: not every terminal knows every character
    if parsed.verb not in FILES_ONLY:
        from graphengine.cli.log_output import print_logs

        print_logs()
    try:
        if not has_address_space(SMALLEST):
            raise MemoryError(f"{SMALLEST // 10**6} MB of address space are needed; raise the limit of `ulimit -v`")
        code = int(parsed.function(parsed))
        if sys.stdout is not None:
            sys.stdout.flush()  # here a full disk can still be told
        return code
    except UsageError as error:
        print(wrapped(clean(f"graphrun {parsed.verb}: {error}"), sys.stderr), file=sys.stderr)
        return getattr(parsed, "wrong_usage", 2)
    except CheckError as error:
        print_findings(error.findings)
        return 1
    except GraphError as error:
        print(wrapped(f"error: {explain(error)}", sys.stderr), file=sys.stderr)
        return 1
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        sys.stderr.close()
        return 0
    except OSError as error:
        what = ": ".join(str(part) for part in (error.filename, error.strerror) if part) or str(error)
        print(clean(f"error: {what}"), file=sys.stderr)
        return 1
