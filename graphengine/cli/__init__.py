"""`graphrun`: one module a verb. Nothing heavy is imported until a verb runs."""

from __future__ import annotations

import argparse
import importlib
import io
import sys
from collections.abc import Sequence
from typing import NoReturn

from graphengine import __version__

VERBS = {
    "run": "run a scene or a graph",
    "ctl": "ask a running session for something: pause, step, reset, spawn, push",
    "replay": "a recorded run once more, compared byte by byte",
    "check": "tell everything that is wrong with scenes and graphs",
    "show": "what a graph is made of, in which order it runs, what was generated",
    "snapshot": "a picture of a scene, from above, of a robot or by one of its cameras",
    "map": "an occupancy map of a scene, as nav2's map_server reads it",
    "import": "graphs of an Isaac Sim script or USD stage as YAML",
    "export": "a graph as a script that builds it in Isaac Sim",
    "import-urdf": "a robot file from a URDF, a xacro file, or the description of a running ROS 2 system",
    "topics": "what a scene would say and hear, without running it: topics, types, QoS, frames, rates",
    "topic": "topics of a live network, with or without ROS: list, info, echo, hz, delay, pub",
    "tf": "the tree of frames on a live network",
    "teleop": "drive a robot from the keyboard",
    "nodes": "node types and their ports",
    "schema": "JSON Schema of the three kinds of file, for editors",
}

MODULES = {"import": "import_graph"}
"""Modules of verbs that are words of Python."""


class Parser(argparse.ArgumentParser):
    """A parser that tells a mistake as the verbs do: in one sentence, which cannot steer a terminal."""

    def error(self, message: str) -> NoReturn:
        """Tell what is wrong with the command line, and leave with 2."""
        from graphengine.cli.common import clean

        self.exit(2, clean(f"{self.prog}: {message}\n  see {self.prog} --help\n"))


def make_parser(verb: str | None = None) -> argparse.ArgumentParser:
    """The command line; only the verb that is meant brings its arguments."""
    parser = Parser(
        prog="graphrun", description="OmniGraph-style ActionGraphs in YAML, run against MuJoCo, seen by ROS 2."
    )
    parser.add_argument("--version", action="version", version=f"graphrun {__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, summary in VERBS.items():
        sub = verbs.add_parser(name, help=summary, description=f"{summary[0].upper()}{summary[1:]}.")
        if name == verb:
            module = importlib.import_module(f"graphengine.cli.{MODULES.get(name, name).replace('-', '_')}")
            module.add_arguments(sub)
            sub.set_defaults(function=module.execute)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """The program, with the arguments of the command line, or with these.

    Returns:
        0: as it should be, also after Ctrl-C in a run; 1: errors in files or in the run; 2: a command line that makes no
        sense; 130: Ctrl-C before there was a run, or a result.
    """
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        return _execute(make_parser(next((word for word in given if word in VERBS), None)).parse_args(given))
    except KeyboardInterrupt:
        return 130


def _execute(parsed: argparse.Namespace) -> int:
    """The verb's own exit code, or that of what it raised, which is told."""
    from graphengine.cli.common import clean, explain
    from graphengine.diagnostics import CheckError, GraphError, UsageError

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr has it: not every terminal knows every character
    try:
        code = int(parsed.function(parsed))
        if sys.stdout is not None:
            sys.stdout.flush()  # here a full disk can still be told
        return code
    except UsageError as error:
        print(clean(f"graphrun {parsed.verb}: {error}"), file=sys.stderr)
        return 2
    except CheckError as error:
        print(error, file=sys.stderr)
        return 1
    except GraphError as error:
        print(f"error: {explain(error)}", file=sys.stderr)
        return 1
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        sys.stderr.close()
        return 0
    except OSError as error:
        what = ": ".join(str(part) for part in (error.filename, error.strerror) if part) or str(error)
        print(clean(f"error: {what}"), file=sys.stderr)
        return 1
