"""`graphrun import`: graphs of an Isaac Sim script or of a USD stage, as YAML files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphengine.diagnostics import Findings
    from graphengine.omnigraph.recorded import RecordedGraph
    from graphengine.omnigraph.stage.reading import ImportedStage
    from graphengine.registry import Registry

LONGEST = 10
"""Notes that are told one by one."""
BESIDE = " belongs to no graph and is left out"
"""How notes end of what a script does beside; they become one."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    parser.add_argument("file", metavar="SCRIPT|STAGE", type=Path, help="a .py file, or a .usda, .usd or .usdc file")
    parser.add_argument(
        "-o", "--output", metavar="FOLDER", type=Path, default=Path(), help="where the files go (default here)"
    )
    parser.add_argument("--force", action="store_true", help="write over files that are there")
    parser.add_argument(
        "--allow", metavar="FOLDER", type=Path, action="append", default=[], help="folder that may also be read"
    )
    parser.add_argument(
        "--import", metavar="MODULE", dest="modules", action="append", default=[], help="Python module with node types"
    )
    parser.epilog = "What stands behind -- is what the script finds in sys.argv."
    parse = parser.parse_known_args

    def parse_before_dashes(
        given: Sequence[str], namespace: argparse.Namespace
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse what is ours; argparse would look for options among the script's arguments too."""
        end = list(given).index("--") if "--" in given else len(given)
        parsed, unknown = parse(given[:end], namespace)
        parsed.arguments = list(given[end + 1 :])
        return parsed, unknown

    parser.parse_known_args = parse_before_dashes  # type: ignore[method-assign, assignment]


def execute(arguments: argparse.Namespace) -> int:
    """0 when the files are written, 1 when there is nothing to write, which is told."""
    from graphengine.cli.common import clean, make_registry, print_findings
    from graphengine.diagnostics import Findings, UsageError
    from graphengine.omnigraph.graph_file import compose, file_names
    from graphengine.output import write_together
    from graphengine.registry import default_registry

    _check_usage(arguments)
    registry = make_registry(arguments.modules) if arguments.modules else default_registry()
    findings = Findings()
    found = _read(arguments, registry, findings)
    graphs = found.graphs
    if not graphs and not found.namespaces and not findings.errors:
        hints = [*_never_called(arguments.file), *(f"a variant may: {choice}" for choice in found.choices)]
        findings.add("G401", f"{str(arguments.file)!r} builds no graph", None, *hints)
    names = file_names(graphs)
    files = {
        arguments.output / f"{name}.yaml": compose(graph, name, registry, findings, _origin(arguments.file, graph))
        for graph, name in zip(graphs, names, strict=True)
    }
    print_findings(findings, notes=False)
    if findings.errors:
        return 1
    there = [str(path) for path in files if path.exists()]
    if there and not arguments.force:
        raise UsageError(f"{', '.join(there)}: already there; --force writes over it")
    write_together({path: text.encode() for path, text in files.items()})
    more = ["in a scene:", found.scene_lines().rstrip()] if found.namespaces else []
    print(clean("\n".join([*_report(files, graphs, findings), *more])))
    return 0


def _check_usage(arguments: argparse.Namespace) -> None:
    from graphengine.diagnostics import UsageError

    if not arguments.file.is_file():
        raise UsageError(f"no file {str(arguments.file)!r}")
    if arguments.file.suffix not in (".py", ".usd", ".usda", ".usdc", ".usdz"):
        raise UsageError(f"{arguments.file}: what can be imported ends in .py, .usda, .usd or .usdc")
    if arguments.arguments and arguments.file.suffix != ".py":
        raise UsageError(f"{arguments.arguments[0]}: only a script takes arguments")
    for folder in (arguments.output, *arguments.allow):
        if not folder.is_dir():
            raise UsageError(f"no folder {str(folder)!r}")


def _read(arguments: argparse.Namespace, registry: Registry, findings: Findings) -> ImportedStage:
    """The graphs of the file, and what is to be told of it beside."""
    from graphengine.cli.common import installed_packages
    from graphengine.files import Files
    from graphengine.omnigraph.stage.reading import ImportedStage, read_stage

    if arguments.file.suffix == ".py":
        from graphengine.omnigraph.script.reading import read_script

        namespaces: dict[str, str] = {}
        given = arguments.file, findings, arguments.arguments, arguments.allow
        graphs = read_script(*given, namespaces=namespaces, types=registry.types)
        return ImportedStage(graphs, namespaces)
    files = Files.of(arguments.file, arguments.allow, Path.cwd(), installed_packages())
    return read_stage(arguments.file, files, registry, findings) or ImportedStage()


def _never_called(path: Path) -> Iterator[str]:
    """Functions of a script that build graphs, which nobody calls."""
    if path.suffix != ".py":
        return
    import importlib.util

    from graphengine.omnigraph.script.places import Script

    building = Script(str(path), importlib.util.decode_source(path.read_bytes())).functions_that_call("edit")
    if building:
        yield f"functions that build graphs are not called: {', '.join(building[:LONGEST])}"
        yield "import it in a script beside it, call them there, and import that script"


def _origin(path: Path, graph: RecordedGraph) -> str:
    return f"{path.name}, line {graph.span.line}" if graph.span is not None and path.suffix == ".py" else path.name


def _report(files: dict[Path, str], graphs: Sequence[RecordedGraph], findings: Findings) -> Iterator[str]:
    """What was written, and what has changed on the way, for people."""
    from graphengine.cli.common import counted, near

    for path, graph in zip(files, graphs, strict=True):
        parts = counted(len(graph.nodes), "node"), counted(len(graph.wires), "wire")
        yield f"wrote {near(str(path))}: {', '.join(parts)}, at {graph.path}"
    notes = [finding for finding in findings.sorted() if finding.severity == "note"]
    passed = [note.message.removesuffix(BESIDE) for note in notes if note.message.endswith(BESIDE)]
    notes = [note for note in notes if not note.message.endswith(BESIDE)]
    for note in notes[:LONGEST]:
        at = f"{note.span}: " if note.span is not None else ""
        yield f"note: {at}{'; '.join([note.message, *note.help])}"
    if len(notes) > LONGEST:
        yield f"note: … ({len(notes) - LONGEST} more)"
    if passed:
        more = f", … ({len(passed) - LONGEST} more)" if len(passed) > LONGEST else ""
        yield f"note: left out is what belongs to no graph: {', '.join(passed[:LONGEST])}{more}"
