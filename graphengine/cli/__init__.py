"""`graphrun`: one module a verb. Nothing heavy is imported until a verb runs."""

from __future__ import annotations

import argparse
import atexit
import gc
import importlib
import io
import re
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from graphengine.format.version import __version__

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

OUT_OF_MEMORY = 3
"""Exit code."""

MODULES = {"import": "import_graph"}
"""Modules of verbs that are words of Python."""


class Parser(argparse.ArgumentParser):
    """A parser that reports a mistake as the verbs do: in one sentence that cannot steer a terminal, with what is near."""

    def parse_known_args(  # type: ignore[override]  # typeshed's overloads say no more
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse, and refuse options that the parser of the verb does not know, which knows those that are near."""
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            options = [word.partition("=")[0] for word in unknown if word.startswith("--")]
            self.error(f"unrecognized arguments: {' '.join(unknown)}{_hint(options, self._option_string_actions)}")
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """Tell what is wrong with the command line, and leave with 2."""
        from graphengine.cli.common import clean

        if choice := _CHOICE.search(message):
            message += _hint([choice[1]], re.findall(r"[\w-]+", choice[2]))
        self.exit(2, clean(f"{self.prog}: {message}\n  see {self.prog} --help\n"))


class Version(argparse.Action):
    """Prints the version; with `--verbose`, on whichever side, also what this machine can confine strangers' files with."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print it, and leave with 0."""
        print(f"graphrun {__version__}")
        if parser.get_default("verbose"):
            from graphengine.sandbox.borders import describe

            print(f"confinement: {describe()}")
        parser.exit()


_CHOICE = re.compile(r"invalid choice: '(.*)' \(choose from (.*)\)")


def _hint(words: Iterable[str], legal: Iterable[str]) -> str:
    """A line with what may be meant, for each word to which something is near."""
    from graphengine.format.wording import did_you_mean

    names = list(legal)
    return "".join(f"\n  {near}" for word in words if (near := did_you_mean(word, names)))


def make_parser(verb: str | None = None) -> argparse.ArgumentParser:
    """The command line; only the verb that is meant brings its arguments."""
    parser = Parser(
        prog="graphrun", description="OmniGraph-style ActionGraphs in YAML, run against MuJoCo, seen by ROS 2."
    )
    parser.add_argument("--version", action=Version, nargs=0, help="show the version and exit")
    parser.add_argument(
        "--verbose", action="store_true", help="with --version: the borders around strangers' files too"
    )
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
        sense; 3: too little memory; 130: Ctrl-C before there was a run, or a result.
    """
    if arguments is None:  # called by `graphrun`, not by a test or another program in its own process
        gc.set_threshold(10_000)  # collections at the default take a sixth of the start, and free almost nothing
        atexit.register(gc.freeze)  # the collection at exit takes up to a second after a run, and frees nothing of use
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        parser = make_parser(next((word for word in given if word in VERBS), None))
        parser.set_defaults(verbose="--verbose" in given)
        return _execute(parser.parse_args(given))
    except KeyboardInterrupt:
        return 130


def _execute(parsed: argparse.Namespace) -> int:
    """The verb's own exit code, or that of what it raised, which is told."""
    from graphengine.cli.common import clean, explain
    from graphengine.format.errors import CheckError, GraphError, UsageError
    from graphengine.format.process_limits import SMALLEST, has_address_space

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr has it: not every terminal knows every character
    try:
        if not has_address_space(SMALLEST):
            raise MemoryError(f"{SMALLEST // 10**6} MB of address space are needed; raise the limit of `ulimit -v`")
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
    except (MemoryError, RuntimeError) as error:
        if not isinstance(error, MemoryError) and str(error) != "can't start new thread":
            raise
        print(clean(": ".join(("error: out of memory", *filter(None, [str(error)])))), file=sys.stderr)
        return OUT_OF_MEMORY
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        sys.stderr.close()
        return 0
    except OSError as error:
        what = ": ".join(str(part) for part in (error.filename, error.strerror) if part) or str(error)
        print(clean(f"error: {what}"), file=sys.stderr)
        return 1
