"""Code that several verbs share: arguments and their parsing, loading of files, and printing of findings."""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import os
import re
import sys
import textwrap
import traceback
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli import terminal
from graphengine.cli.finding_formats import coloured
from graphengine.cli.options import add_flag, add_repeatable, add_value
from graphengine.cli.progress import progress
from graphengine.cli.quantities import ip_address, port, whole
from graphengine.format.diagnostics import CheckError, Finding, Findings
from graphengine.format.errors import GraphError, NodeError, UsageError
from graphengine.format.files import find_file, installed_packages, near
from graphengine.messages.distros import DISTROS, Distro, sourced_distro

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.scene.loaded_scene import LoadedScene, Options


def add_file_arguments(parser: argparse.ArgumentParser, *, many: bool = False, recordings: bool = False) -> None:
    """Add the argument for a scene or graph file, or for several (`many`), and the options that change how it is loaded.

    Args:
        parser: parser to add the arguments to.
        many: whether several files can be given.
        recordings: whether the help names recordings too.
    """
    what = "a scene or graph file, or the name of an included one, such as dd100_warehouse or dd100/cmd_vel"
    what += "; or a recording made by `graphrun run --record FILE`" if recordings else ""
    parser.add_argument("files" if many else "file", metavar="SCENE|GRAPH", nargs="+" if many else None, help=what)
    add_value(parser, "--scene", "SCENE", "scene in which to load a graph file")
    inputs = "value for an input, [ROBOT/][GRAPH/]NODE.PORT=VALUE, globs allowed"
    add_repeatable(parser, "--set", "NODE.PORT=VALUE", inputs)
    add_flag(parser, "--robot-state", "publish the topics of robot_state_publisher for each robot")
    localization = "truth: publish map -> odom of each mobile robot from its true pose, instead of AMCL or SLAM"
    parser.add_argument("--localization", choices=("truth",), help=localization)
    rays = "ray casting of lidars: mujoco, fast (needs numba), or auto: fast if possible (default auto)"
    parser.add_argument("--rays", choices=("auto", "mujoco", "fast"), default="auto", help=rays)
    parser.add_argument("--seed", type=whole, default=0, help="seed of all random generators (default 0)")
    add_access_arguments(parser)


def add_access_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options for the files and modules that a scene may use, and for the permissions of its graphs."""
    add_allow_argument(parser)
    add_import_argument(parser)
    add_repeatable(parser, "--env", "NAME", "let graphs read this environment variable with IsaacReadEnvVar")
    scripts = "let graphs run the Python code of their ScriptNodes without a sandbox; read the code first"
    add_flag(parser, "--allow-scripts", scripts)


class _Transports:
    """The legal values of `--transport` with their help, looked up at the first use, because packages can add transports."""

    def __init__(self, reaching_others: bool) -> None:
        self._reaching_others = reaching_others

    @cached_property
    def _helps(self) -> dict[str, str]:
        from graphengine.ros.transports.select import transport_helps

        return transport_helps(reaching_others=self._reaching_others)

    def __iter__(self) -> Iterator[str]:
        return (f"{name} ({line})" for name, line in self._helps.items())

    def __contains__(self, name: object) -> bool:
        return name in self._helps


def add_transport_argument(parser: argparse.ArgumentParser, what: str = "", *, reaching_others: bool = True) -> None:
    """Add `--transport`.

    Args:
        parser: parser to add the option to.
        what: purpose of the transport for the help, such as ` for --topic and --node`.
        reaching_others: whether to leave out transports whose messages stay in the process.
    """
    what = f"connection to ROS 2{what} (default auto): %(choices)s"
    choices: Any = _Transports(reaching_others)
    add_value(parser, "--transport", "NAME", what, choices=choices, default="auto")


def add_import_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--import` for Python modules that define node types."""
    what = "import a Python module with additional node types, such as my_robot.nodes"
    add_repeatable(parser, "--import", "MODULE", what, dest="modules")


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--view-host` and `--view-port` for the web page."""
    host = "address of the web page (default 127.0.0.1)"
    add_value(parser, "--view-host", "ADDRESS", host, type=ip_address, default="127.0.0.1")
    add_value(parser, "--view-port", "PORT", "port of the web page (default: a free port)", type=port, default=0)


def environment(arguments: argparse.Namespace) -> dict[str, str]:
    """Return a dict from the environment variables given by `--env` to their values, which are empty for unset variables."""
    return {name: os.environ.get(name, "") for name in arguments.env}


def add_allow_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--allow` for folders that may be read, and the options for message types, `--distro` and `--msg-path`."""
    what = "also let scenes, robots and graphs refer to files in this folder"
    add_repeatable(parser, "--allow", "FOLDER", what, type=Path)
    add_message_path(parser)


def add_message_path(parser: argparse.ArgumentParser) -> None:
    """Add `--distro`, which selects the ROS 2 distribution of the message types, and `--msg-path`, which adds types."""
    which = "ROS 2 distribution whose message types are used (default: the sourced one, else jazzy)"
    parser.add_argument("--distro", choices=DISTROS, help=which)
    what = "additional message types: a package, a folder with packages, or one .msg, .srv or .action file"
    add_repeatable(parser, "--msg-path", "PATH", what, type=Path)


def clean(text: str, kept: str = "") -> str:
    """Return the text with U+FFFD in place of each character that controls a terminal or misleads its reader.

    All characters that are not printable are replaced, such as control characters and U+202E, which reverses the order of text.
    Line breaks and the characters in `kept` stay.
    """
    return "".join(c if c.isprintable() or c == "\n" or c in kept else "\N{REPLACEMENT CHARACTER}" for c in text)


def explain(error: GraphError) -> str:
    """Return the message of an error; for an exception in a node, also the first and the last frame of its traceback."""
    cause = error.__cause__ if isinstance(error, NodeError) else None
    if cause is None:
        return clean(str(error))
    from graphengine.runtime import executor

    frames = traceback.extract_tb(cause.__traceback__)
    own = [frame for frame in frames if frame.filename != executor.__file__ and not frame.filename.startswith("<")]
    places = [f"  in {frame.name}, {near(frame.filename)}:{frame.lineno}: {frame.line or ''}" for frame in own]
    return clean("\n".join([str(error), *dict.fromkeys(places[:1] + places[-1:])]))


def check_suffix(path: Path, *suffixes: str) -> None:
    """Check the suffix of a file to write, to protect files of other types from being overwritten.

    Raises:
        UsageError: the name has none of the suffixes.
    """
    if path.suffix.lower() not in suffixes:
        raise UsageError(f"{path}: the name must end in {suffixes[0]}; files with other endings are not overwritten")


def counted(number: int, thing: str) -> str:
    """Return a number with a noun in singular or plural, such as `1 graph` or `2 graphs`."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def make_options(arguments: argparse.Namespace) -> Options:
    """Return the loading options from the arguments that `add_file_arguments` added.

    Raises:
        UsageError: the text after `--set` is not `NODE.PORT=VALUE`, a file or folder does not exist, or a module cannot be
            imported.
    """
    return dataclasses.replace(
        reading_options(arguments),
        overrides=dict(parse_set(text) for text in arguments.set),
        seed=arguments.seed,
        robot_state=arguments.robot_state,
        localization=arguments.localization,
        rays=arguments.rays,
        scene=find_file(arguments.scene) if arguments.scene else None,
        registry=make_registry(arguments.modules) if arguments.modules else None,
        environment=environment(arguments),
        scripts=arguments.allow_scripts,
    )


def reading_options(arguments: argparse.Namespace) -> Options:
    """Return loading options from `--allow`, `--msg-path`, `--distro` and the ROS packages installed on this machine.

    Raises:
        UsageError: a file or folder does not exist.
    """
    from graphengine.scene.loaded_scene import Options

    for folder in arguments.allow:
        if not folder.is_dir():
            raise UsageError(f"--allow {folder}: no such folder")
    paths = message_paths(arguments)
    return Options(
        allowed=arguments.allow,
        installed=installed_packages(),
        message_paths=paths,
        distro=chosen_distro(arguments),
        near=Path.cwd(),
    )


def chosen_distro(arguments: argparse.Namespace) -> Distro:
    """Return the ROS 2 distribution given by `--distro`; without the option, the sourced distribution, or Jazzy."""
    given: Distro | None = arguments.distro
    return given or sourced_distro(os.environ)


def message_paths(arguments: argparse.Namespace) -> list[Path]:
    """Return the paths given by `--msg-path`.

    Raises:
        UsageError: a path does not exist.
    """
    given: list[Path] = arguments.msg_path
    for path in given:
        if not (path.is_file() or path.is_dir()):
            raise UsageError(f"--msg-path {path}: no such file or folder")
    return given


def make_registry(modules: Sequence[str]) -> Any:
    """Import the modules; return a registry of the installed node types and the node types in these modules.

    Raises:
        UsageError: a module cannot be imported.
    """
    from graphengine.compiler.registry import default_registry

    registry = default_registry().copy()  # others in this process share the original
    sys.path.append("")  # a module of the working directory; last, as that may be a stranger's
    for name in modules:
        if not all(part.isidentifier() for part in name.split(".")):
            raise UsageError(f"--import {name}: write the name of a module, such as my_robot.nodes")
        try:
            module = importlib.import_module(name)
        except (Exception, SystemExit) as error:  # a module may fail in any way
            raise UsageError(f"--import {name}: {_failure(error, name)}") from None
        registry.add_module(module, name)
    return registry


def _failure(error: BaseException, name: str) -> str:
    """Return the reason why a module could not be imported, and the last place of the user's code in the traceback, if any."""
    if isinstance(error, ModuleNotFoundError) and name.endswith(".py"):
        return f"write the name of the module, {name.removesuffix('.py')}"
    what = str(error) if isinstance(error, ImportError) else f"{type(error).__name__}: {error}"
    engine = (str(Path(__file__).parents[1]), importlib.__file__, "<frozen")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(engine)]
    return f"{what} ({near(frames[-1].filename)}:{frames[-1].lineno})" if frames else what


def parse_set(text: str, option: str = "--set ") -> tuple[str, Any]:
    """Split `Node.port=value` into the address of the port and the value, parsed as YAML.

    Args:
        text: the text to split.
        option: name of the option; messages begin with it.

    Raises:
        UsageError: the text has another form, or the value is not YAML.
    """
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
    """Load and check the scene or graph that the command line names; the returned scene has the errors as findings."""
    from graphengine.scene import build

    path = find_file(arguments.file)
    with progress(f"loading {path.name}"):
        return build.load(path, make_options(arguments))


def open_scene(arguments: argparse.Namespace) -> Scene:
    """Load the scene or graph that the command line names, and print its findings; raise CheckError if it has errors."""
    return open_file(find_file(arguments.file), make_options(arguments), arguments.modules)


def open_file(path: Path, options: Options, modules: Sequence[str] = (), *, graphs: bool = True) -> Scene:
    """Load a scene or graph, and print its findings.

    Args:
        path: the file.
        options: options of loading.
        modules: names of imported modules with node types.
        graphs: whether to load the graphs of the scene too.

    Raises:
        CheckError: the files have errors. The exception has the errors and warnings, without notes.
    """
    from graphengine.api.scene_loading import open_scene

    try:
        with progress(f"loading {path.name}"):
            opened = open_scene(path, options, modules, graphs=graphs)
    except CheckError as error:
        raise CheckError([finding for finding in error.findings if finding.severity != "note"]) from None
    print_findings(opened.findings, notes=False)
    return opened


def refuse_to_overwrite(paths: Iterable[Path], *, force: bool) -> None:
    """Check that none of the files exists, unless `force` is set.

    Raises:
        UsageError: a file exists and `force` is not set.
    """
    there = [str(path) for path in paths if path.exists()]
    if there and not force:
        raise UsageError(f"{', '.join(there)}: existing files are overwritten only with --force")


def print_findings(findings: Findings | Sequence[Finding], *, stream: Any = None, notes: bool = True) -> None:
    """Print findings, each with an excerpt of its file, and in colours on a terminal; leave out notes unless `notes` is set.

    A sequence is printed in its order, and `Findings` in the order of files and lines.
    """
    stream = stream or sys.stderr
    colours = terminal.uses_colours(stream)
    for finding in findings if isinstance(findings, Sequence) else findings.sorted():
        if notes or finding.severity != "note":
            text = terminal.wrapped(finding.render(), stream)
            print(coloured(finding, text) if colours else text, file=stream)


def table(rows: Sequence[Sequence[str]], *, indent: str = "") -> str:
    """Return rows as text with aligned columns, one line per row, without trailing spaces."""
    *widths, _ = (max(map(len, column)) for column in zip(*rows, strict=True))
    padded = ([*map(str.ljust, row, widths), row[-1]] for row in rows)
    return "\n".join((indent + "  ".join(cells)).rstrip() for cells in padded)


def fitted_table(rows: Sequence[Sequence[str]], lead: int, *, indent: str = "") -> str:
    """Return rows as text with aligned columns; on a narrow terminal, only the first columns form the table.

    The cells of the other columns then follow in wrapped lines below each row. No text is cut off.

    Args:
        rows: texts of the columns; all rows have the same number of columns.
        lead: number of columns that stay in the table if they fit.
        indent: text before each row.
    """
    whole_table, most = table(rows, indent=indent), terminal.width(sys.stdout)
    if not terminal.shows_stdout() or _widest(whole_table) <= most:
        return whole_table
    while lead > 1 and _widest(table([row[:lead] for row in rows], indent=indent)) > most:
        lead -= 1
    lines = []
    for line, row in zip(table([row[:lead] for row in rows], indent=indent).splitlines(), rows, strict=True):
        below = "; ".join(filter(None, row[lead:]))
        more = {"initial_indent": f"{indent}    ", "subsequent_indent": f"{indent}    ", "break_on_hyphens": False}
        lines += [line, *textwrap.wrap(below, most, **more)]  # type: ignore[arg-type]
    return "\n".join(lines)


def fitted_text(text: str) -> str:
    """Return a text with its paragraphs filled to the width of the terminal if standard output is a narrow terminal.

    Paragraphs with lists or indented lines stay unchanged.
    """
    most = terminal.width(sys.stdout)
    if not terminal.shows_stdout() or _widest(text) <= most:
        return text
    paragraphs = text.split("\n\n")
    plain = [not re.search(r"^[\s*-]", paragraph, re.MULTILINE) for paragraph in paragraphs]
    return "\n\n".join(textwrap.fill(p, most) if fills else p for p, fills in zip(paragraphs, plain, strict=True))


def _widest(text: str) -> int:
    return max(map(len, text.splitlines()), default=0)


def log_problem(severity: str, node: str, message: str) -> None:
    """Print the message of a node on standard error, unless the severity is `info`."""
    if severity != "info":
        print(clean(f"{severity}: {node + ': ' if node else ''}{message}"), file=sys.stderr)
