"""`graphrun import`: convert the ActionGraphs of an Isaac Sim script or USD stage to YAML files."""

from __future__ import annotations

import argparse
import ast
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import (
    add_import_argument,
    clean,
    counted,
    make_registry,
    print_findings,
    refuse_to_overwrite,
)
from graphengine.cli.options import add_flag, add_repeatable, add_value, split_arguments
from graphengine.cli.quantities import whole
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files, near, require_file, require_suffix
from graphengine.format.wording import listing

if TYPE_CHECKING:
    from graphengine.compiler.registry import Registry
    from graphengine.isaac.recorded_graph import RecordedGraph
    from graphengine.isaac.stage.stage_reader import ImportedStage

LONGEST = 10
"""Maximum number of notes to print; of further notes, only the number is printed."""
BESIDE = " does not belong to a graph and is left out"
"""End of each note on a script statement outside of graphs; these notes are printed as a single note."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun import` to its parser."""
    add_value(parser, "file", "SCRIPT|STAGE", "a script (.py), or a USD stage (.usda, .usd, .usdc)", type=Path)
    folder = "folder to write the YAML files to (default: the working directory)"
    add_value(parser, "--output", "FOLDER", folder, short="-o", type=Path, default=Path())
    add_flag(parser, "--force", "overwrite existing files")
    add_repeatable(parser, "--allow", "FOLDER", "also let the script or stage read files in this folder", type=Path)
    add_import_argument(parser)
    robot = "prim path of the robot in the script or stage; the files contain $(robot) instead, so that a robot file can use them"
    add_value(parser, "--robot", "PATH", robot, type=_prim_path)
    trust = "run the script or read the stage even if this machine's kernel has no sandbox for it; its code then has all your "
    trust += "permissions: it can read and write your files, start programs and use the network"
    add_flag(parser, "--trust", trust)
    call = "function call to make after loading a script that only defines functions, such as "
    call += "\"build('/World/robot')\"; unknown names stand for objects of Omniverse"
    add_repeatable(parser, "--call", "CALL", call, type=_call)
    assumed = "path of a prim or file that exists for the script, or a name that is true for it, such as "
    assumed += "rosgraph.is_master_online"
    add_repeatable(parser, "--assume", "PATH|NAME", assumed)
    variable = "set an environment variable for the script; without VALUE, to its value in your environment"
    add_repeatable(parser, "--env", "NAME[=VALUE]", variable, type=_variable)
    impulses = "period, in ticks, at which the graph triggers nodes that the script triggers in a loop (default: never)"
    add_value(parser, "--impulse-every", "TICKS", impulses, type=whole, default=0)
    parser.epilog = "Arguments after -- are passed to the script, in sys.argv."
    parser.set_defaults(arguments=[])
    split_arguments(parser, _at_dashes)  # argparse would search the arguments of the script for options


def _at_dashes(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the words before and after the first `--`."""
    end = words.index("--") if "--" in words else len(words)
    return words[:end], words[end + 1 :]


def execute(arguments: argparse.Namespace) -> int:
    """Write a YAML file for each graph.

    Returns:
        0 on success, 1 if the script or stage has errors or no graphs; the reason is reported.
    """
    from graphengine.compiler.registry import default_registry
    from graphengine.isaac.graph_file import compose, file_names

    _check_usage(arguments)
    registry = make_registry(arguments.modules) if arguments.modules else default_registry()
    findings = Findings()
    found = _read(arguments, registry, findings)
    graphs = found.graphs
    if not graphs and not found.namespaces and not findings.errors:
        hints = [f"a variant may have one: {choice}" for choice in found.choices]
        findings.add("G401", f"{str(arguments.file)!r} has no graph", None, *hints)
    names, robot = file_names(graphs), arguments.robot or ""
    used = [bool(robot and graph.use_parameter("robot", robot)) for graph in graphs]
    if robot and graphs and not any(used) and not findings.errors:
        at = ", ".join(dict.fromkeys(graph.path for graph in graphs[:LONGEST]))
        raise UsageError(f"--robot {robot}: no graph names this prim; the graphs are at {at}")
    files = {
        arguments.output / f"{name}.yaml": compose(
            graph, name, registry, findings, _origin(arguments.file, graph), robot if named else ""
        )
        for graph, name, named in zip(graphs, names, used, strict=True)
    }
    print_findings(findings, notes=False)
    if findings.errors:
        print(clean("\n".join(_notes(findings))), file=sys.stderr)
        return 1
    refuse_to_overwrite(files, force=arguments.force)
    write_together({path: text.encode() for path, text in files.items()})
    more = ["in a scene:", found.scene_lines().rstrip()] if found.namespaces else []
    print(clean("\n".join([*_report(files, graphs, findings), *more])))
    return 0


def _check_usage(arguments: argparse.Namespace) -> None:
    require_file(arguments.file)
    require_suffix(arguments.file, "import")
    if arguments.file.suffix not in (".py", ".usd", ".usda", ".usdc", ".usdz"):
        raise UsageError(f"{arguments.file}: not an importable file; give a .py, .usda, .usd or .usdc file")
    if arguments.impulse_every < 0:
        raise UsageError(f"--impulse-every {arguments.impulse_every}: write a number of ticks, 1 or more")
    if arguments.arguments and arguments.file.suffix != ".py":
        raise UsageError(f"{arguments.arguments[0]}: only a script takes arguments, not a USD stage")
    for folder in arguments.allow:
        if not folder.is_dir():
            raise UsageError(f"--allow: no folder {str(folder)!r}")
    if arguments.output.exists() and not arguments.output.is_dir():
        raise UsageError(f"-o {arguments.output}: this is not a folder")


def _read(arguments: argparse.Namespace, registry: Registry, findings: Findings) -> ImportedStage:
    """Return the graphs of the script or stage, and the namespaces for the report."""
    from graphengine.isaac.recorded_graph import RecordedGraph
    from graphengine.isaac.stage.stage_reader import ImportedStage, read_stage

    def stage(path: Path, findings: Findings) -> ImportedStage:
        files = Files.of(path, arguments.allow, Path.cwd())
        return read_stage(path, files, registry, findings, trusted=arguments.trust) or ImportedStage()

    def graphs_of(path: Path) -> list[RecordedGraph]:
        """Return the graphs of a stage that the script opens. If the stage cannot be read, add warnings and return no graphs."""
        told, graphs = Findings(), list[RecordedGraph]()
        try:
            graphs = stage(path, told).graphs
        except UsageError as error:
            findings.add("W302", f"the graphs of {path.name} are left out: {error}", None)
        for found in told.items:
            code = "W302" if found.severity == "error" else found.code
            findings.add(code, found.message, found.span, *found.help)
        return graphs

    if arguments.file.suffix == ".py":
        from graphengine.isaac.script.script_reader import ScriptOptions, read_script

        assumed, environment = tuple(arguments.assume), dict(arguments.env)
        options = ScriptOptions(tuple(arguments.call), arguments.impulse_every, assumed, environment)
        namespaces: dict[str, str] = {}
        given = arguments.file, findings, arguments.arguments, arguments.allow
        graphs = read_script(
            *given,
            namespaces=namespaces,
            types=registry.types,
            options=options,
            read_stage=graphs_of,
            trusted=arguments.trust,
        )
        return ImportedStage(graphs, namespaces)
    return stage(arguments.file, findings)


def _variable(text: str) -> tuple[str, str]:
    """Return name and value of an environment variable, from `NAME=VALUE` or from the name of an existing variable."""
    name, equals, value = text.partition("=")
    if not name or "\0" in text or (not equals and name not in os.environ):
        raise argparse.ArgumentTypeError(f"{text!r}: write NAME=VALUE, or the name of an existing environment variable")
    return name, value if equals else os.environ[name]


def _prim_path(text: str) -> str:
    """Return an absolute prim path below the root, without a slash at the end."""
    if not text.startswith("/") or not text.strip("/"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a prim path; write one such as /World/robot")
    return text.rstrip("/")


def _call(text: str) -> str:
    """Return the text of a Python call without surrounding spaces; the sandbox of the script evaluates the call later."""
    try:
        called = isinstance(ast.parse(text.strip(), mode="eval").body, ast.Call)
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        called = False
    if not called:
        example = "build('/World/robot', rate=2) or Robot(Settings('r1')).build()"
        raise argparse.ArgumentTypeError(f"{text!r} is not a function call; write {example}")
    return text.strip()


def _origin(path: Path, graph: RecordedGraph) -> str:
    found = Path(graph.span.source.path) if graph.span is not None else path
    return f"{found.name}, line {graph.span.line}" if graph.span is not None and found.suffix == ".py" else found.name


def _report(files: dict[Path, str], graphs: Sequence[RecordedGraph], findings: Findings) -> Iterator[str]:
    """Yield the lines of the report: the written files, then the notes."""
    for path, graph in zip(files, graphs, strict=True):
        parts = counted(len(graph.nodes), "node"), counted(len(graph.wires), "wire")
        yield f"wrote {near(str(path))}: {', '.join(parts)}, at {graph.path}"
    yield from _notes(findings)


def _notes(findings: Findings) -> Iterator[str]:
    """Yield a line for each note, that is, for each change or omission of the conversion."""
    notes = [finding for finding in findings.sorted() if finding.severity == "note"]
    passed = [note.message.removesuffix(BESIDE) for note in notes if note.message.endswith(BESIDE)]
    notes = [note for note in notes if not note.message.endswith(BESIDE)]
    for note in notes[:LONGEST]:
        at = f"{note.span}: " if note.span is not None else ""
        yield f"{at}note {note.code}: {'; '.join([note.message, *note.help])}"
    if len(notes) > LONGEST:
        yield f"note: … ({len(notes) - LONGEST} more)"
    if passed:
        yield listing(passed, "note N302: left out, because it does not belong to a graph", LONGEST)
