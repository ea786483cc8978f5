"""Shared parts of verbs: finding the given file, `--set`, and printing findings."""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import os
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.quantities import whole
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.errors import CheckError, GraphError, NodeError, UsageError
from graphengine.format.files import find_file, installed_packages, near

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.scene.loaded_scene import LoadedScene, Options


def add_file_arguments(parser: argparse.ArgumentParser, *, many: bool = False) -> None:
    """The file, and what may be changed about it from outside."""
    what = "a scene or graph file, or the name of one that ships, such as dd100_warehouse or dd100/cmd_vel"
    parser.add_argument("files" if many else "file", metavar="SCENE|GRAPH", nargs="+" if many else None, help=what)
    parser.add_argument("--scene", metavar="SCENE", help="scene to put a single graph into")
    add_repeatable(parser, "--set", "NODE.PORT=VALUE", "value of an input; [ROBOT/][GRAPH/]NODE.PORT, globs allowed")
    state = "publish what robot_state_publisher would, for every robot"
    parser.add_argument("--robot-state", action="store_true", help=state)
    rays = "what lidars see with; `fast` needs numba, and `auto` takes it where it serves"
    parser.add_argument("--rays", choices=("auto", "mujoco", "fast"), default="auto", help=rays)
    parser.add_argument("--seed", type=whole, default=0, help="of every random generator (default 0)")
    add_allow_argument(parser)
    add_import_argument(parser)
    add_permission_arguments(parser)


def add_repeatable(parser: argparse._ActionsContainer, option: str, metavar: str, what: str, **more: Any) -> None:
    """An option that may be given several times; without it the list is empty."""
    parser.add_argument(option, metavar=metavar, action="append", default=[], help=what, **more)


class _Transports:
    """What `--transport` takes, looked up when one is given and when help is printed: packages may bring more."""

    def __init__(self, reaching_others: bool) -> None:
        self._reaching_others = reaching_others

    def _helps(self) -> dict[str, str]:
        from graphengine.ros.transports.select import transport_helps

        return transport_helps(reaching_others=self._reaching_others)

    def __iter__(self) -> Iterator[str]:
        return (f"{name} ({line})" for name, line in self._helps().items())

    def __contains__(self, name: object) -> bool:
        return name in self._helps()


def add_transport_argument(parser: argparse.ArgumentParser, what: str = "", *, reaching_others: bool = True) -> None:
    """How to reach ROS 2; `reaching_others` leaves out the transports whose messages stay in the process."""
    what = f"how to reach ROS 2{what} (default auto): %(choices)s"
    choices: Any = _Transports(reaching_others)
    parser.add_argument("--transport", metavar="NAME", choices=choices, default="auto", help=what)


def add_import_argument(parser: argparse.ArgumentParser) -> None:
    """Modules with further node types."""
    add_repeatable(parser, "--import", "MODULE", "Python module with node types", dest="modules")


def add_permission_arguments(parser: argparse.ArgumentParser) -> None:
    """What graphs may do beyond their folder."""
    variable = "variable of the environment that graphs may read; IsaacReadEnvVar reads no other"
    add_repeatable(parser, "--env", "NAME", variable)
    scripts = "let graphs run the Python in their ScriptNodes, which is not confined: read it before"
    parser.add_argument("--allow-scripts", action="store_true", help=scripts)


def environment(arguments: argparse.Namespace) -> dict[str, str]:
    """Values of the variables that `--env` names; those that there are not are empty."""
    return {name: os.environ.get(name, "") for name in arguments.env}


def add_allow_argument(parser: argparse.ArgumentParser) -> None:
    """Where files and message types may be read from, beside the folder of the given file and what is installed."""
    what = "folder that files may also be read from"
    add_repeatable(parser, "--allow", "FOLDER", what, type=Path)
    add_message_path(parser)


def add_message_path(parser: argparse.ArgumentParser) -> None:
    """Where message types lie that neither ship nor are installed."""
    what = "message types: a package, a folder with packages, or one .msg, .srv or .action file"
    add_repeatable(parser, "--msg-path", "PATH", what, type=Path)


def clean(text: str) -> str:
    """Lines that cannot steer a terminal."""
    return "".join(c if c.isprintable() or c == "\n" else "\N{REPLACEMENT CHARACTER}" for c in text)


def explain(error: GraphError) -> str:
    """What went wrong; for a node that raised, also the lines of Python where it did."""
    from graphengine.runtime import executor

    cause = error.__cause__
    frames = traceback.extract_tb(cause.__traceback__) if isinstance(error, NodeError) and cause else []
    own = [frame for frame in frames if frame.filename != executor.__file__ and not frame.filename.startswith("<")]
    places = [f"  in {frame.name}, {near(frame.filename)}:{frame.lineno}: {frame.line or ''}" for frame in own]
    return clean("\n".join([str(error), *dict.fromkeys(places[:1] + places[-1:])]))


def counted(number: int, thing: str) -> str:
    """`1 graph`, `2 graphs`."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def make_options(arguments: argparse.Namespace) -> Options:
    """Options of `add_file_arguments`.

    Raises:
        UsageError: a `--set` without a value, a folder that is none, or a module that cannot be imported.
    """
    return dataclasses.replace(
        reading_options(arguments),
        overrides=dict(parse_set(text) for text in arguments.set),
        seed=arguments.seed,
        robot_state=arguments.robot_state,
        rays=arguments.rays,
        scene=find_file(arguments.scene) if arguments.scene else None,
        registry=make_registry(arguments.modules) if arguments.modules else None,
        environment=environment(arguments),
        scripts=arguments.allow_scripts,
    )


def reading_options(arguments: argparse.Namespace) -> Options:
    """Options of `add_allow_argument`, and of the machine: where files may be read from, and how they are shown.

    Raises:
        UsageError: a file or folder that is not there.
    """
    from graphengine.scene.loaded_scene import Options

    for folder in arguments.allow:
        if not folder.is_dir():
            raise UsageError(f"--allow {folder}: no such folder")
    paths = message_paths(arguments)
    return Options(allowed=arguments.allow, installed=installed_packages(), message_paths=paths, near=Path.cwd())


def message_paths(arguments: argparse.Namespace) -> list[Path]:
    """What `--msg-path` names.

    Raises:
        UsageError: nothing is there.
    """
    given: list[Path] = arguments.msg_path
    for path in given:
        if not (path.is_file() or path.is_dir()):
            raise UsageError(f"--msg-path {path}: no such file or folder")
    return given


def make_registry(modules: Sequence[str]) -> Any:
    """The installed node types and those of the user's modules."""
    from graphengine.compiler.registry import default_registry

    registry = default_registry().copy()  # others in this process share the original
    sys.path.append("")  # a module of the working directory; last, as that may be a stranger's
    for name in modules:
        if not all(part.isidentifier() for part in name.split(".")):
            raise UsageError(f"--import {name}: write the name of a module, as in my_robot.nodes")
        try:
            module = importlib.import_module(name)
        except (Exception, SystemExit) as error:  # a module may fail in any way
            raise UsageError(f"--import {name}: {_failure(error, name)}") from None
        registry.add_module(module, name)
    return registry


def _failure(error: BaseException, name: str) -> str:
    """Why a module could not be imported, and in which line of the user's own."""
    if isinstance(error, ModuleNotFoundError) and name.endswith(".py"):
        return f"write the name of the module, {name.removesuffix('.py')}"
    what = str(error) if isinstance(error, ImportError) else f"{type(error).__name__}: {error}"
    engine = (str(Path(__file__).parents[1]), importlib.__file__, "<frozen")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(engine)]
    return f"{what} ({near(frames[-1].filename)}:{frames[-1].lineno})" if frames else what


def parse_set(text: str, option: str = "--set ") -> tuple[str, Any]:
    """`Node.port=value` as target and YAML value; the option stands before the text in errors."""
    from graphengine.format import document

    target, equals, value = text.partition("=")
    if not equals or "." not in target:
        raise UsageError(f"{option}{text}: write NODE.PORT=VALUE")
    findings = Findings()
    parsed = document.parse(value or '""', "--set", findings)
    if parsed is None or findings.errors:
        raise UsageError(f"{option}{text}: {findings.errors[0].message}")
    return target.strip(), parsed.data


def load(arguments: argparse.Namespace) -> LoadedScene:
    """The checked scene of the given file."""
    from graphengine.scene import build

    return build.load(find_file(arguments.file), make_options(arguments))


def open_scene(arguments: argparse.Namespace) -> Scene | None:
    """The scene of the given file, with its warnings printed; None if there are errors, which are printed too."""
    from graphengine.api import scene

    try:
        opened = scene.open_scene(find_file(arguments.file), make_options(arguments), arguments.modules)
    except CheckError as error:
        print_findings(error.findings, notes=False)
        return None
    print_findings(opened.findings, notes=False)
    return opened


def refuse_to_overwrite(paths: Iterable[Path], *, force: bool) -> None:
    """Refuse to write over files.

    Raises:
        UsageError: one is there, and `--force` is not given.
    """
    there = [str(path) for path in paths if path.exists()]
    if there and not force:
        raise UsageError(f"{', '.join(there)}: already there; --force writes over it")


def print_findings(findings: Findings | Sequence[Finding], *, stream: Any = None, notes: bool = True) -> None:
    """All findings in order, each with its excerpt; notes only when they are wanted."""
    for finding in findings if isinstance(findings, Sequence) else findings.sorted():
        if notes or finding.severity != "note":
            print(finding.render(), file=stream or sys.stderr)


def table(rows: Sequence[Sequence[str]], *, indent: str = "") -> str:
    """Columns as wide as they must be; the last one runs free."""
    if not rows:
        return ""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row[:-1], widths[:-1], strict=True)]
        lines.append((indent + "  ".join([*cells, row[-1]])).rstrip())
    return "\n".join(lines)
