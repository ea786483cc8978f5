"""`graphrun check`: report all errors and warnings in scene, robot and graph files."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import add_file_arguments, counted, make_options, print_findings
from graphengine.cli.finding_formats import annotation, repository_root
from graphengine.cli.options import add_flag
from graphengine.cli.progress import progress
from graphengine.format.diagnostics import Findings, to_json
from graphengine.format.errors import UsageError
from graphengine.format.files import find_file, near

if TYPE_CHECKING:
    from graphengine.scene.loaded_scene import Options

ORDER = ("scene", "robot", "graph", "unreadable")
"""Kinds of files in a folder, in the order in which they are checked."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun check` to its parser."""
    add_file_arguments(parser, many=True)
    add_flag(parser, "--strict", "exit with code 1 also if there are only warnings")
    form = "output format (default text); github prints annotations for pull requests in GitHub Actions"
    parser.add_argument("--format", choices=("text", "json", "github"), default="text", help=form)
    parser.epilog = "In a folder and its subfolders, all scene, robot and graph files are checked. "
    parser.epilog += "`graphrun explain G204` explains the code of a finding, here G204."


def execute(arguments: argparse.Namespace) -> int:
    """Check the files and print all findings; return 1 if there are errors (with `--strict`, errors or warnings), else 0."""
    options = make_options(arguments)
    findings = Findings()
    files = graphs = 0
    with progress("checking"):
        for name in arguments.files:
            given = _in_folder(Path(name)) if os.path.isdir(name) else [("", find_file(name))]
            files += len(given)
            graphs += _check(given, options, findings)
    errors, warnings = len(findings.errors), len(findings.warnings)
    if arguments.format == "json":
        print(to_json(findings.sorted()))
    else:
        if arguments.format == "github":
            root = repository_root()
            for finding in findings.sorted():
                print(annotation(finding, root))
        else:
            print_findings(findings, stream=sys.stdout)
            for finding in [*findings.errors, *findings.warnings, *findings.items][:1]:
                print(f"explain a code: graphrun explain {finding.code}")
        read = f"{counted(files, 'file')}, {counted(graphs, 'graph')}"
        print(f"{read}: {counted(errors, 'error')}, {counted(warnings, 'warning')}")
    return 1 if errors or (arguments.strict and warnings) else 0


def _check(given: Sequence[tuple[str, Path]], options: Options, findings: Findings) -> int:
    """Check files and add their findings; return the number of graphs.

    Args:
        given: kind and path of each file. Files that an earlier file uses are skipped, because they were checked with it.
        options: options of loading.
        findings: receives the findings.
    """
    from graphengine.scene import build

    graphs, used = 0, set[Path]()
    for kind, path in given:
        if path.resolve() in used:
            continue
        scene = build.check_robot(path, options) if kind == "robot" else build.load(path, options)
        graphs += len(scene.graphs)
        used |= {other.resolve() for other in scene.files.used}
        findings.items += [item for item in scene.findings.items if item not in findings.items]
    return graphs


def _in_folder(folder: Path) -> list[tuple[str, Path]]:
    """Return kind and path of all files to check in a folder and its subfolders: scenes, robots, graphs, unreadable YAML files.

    Raises:
        UsageError: there are no such files.
    """
    from graphengine.format import document, spec_reader

    found: dict[str, list[Path]] = {kind: [] for kind in ORDER}
    for path in sorted(folder.rglob("*.y*ml")):
        inside = path.relative_to(folder).parts
        if path.is_file() and not any(part.startswith(".") for part in inside):
            read = document.load(path, Findings())
            kind = spec_reader.kind_of(read) if read is not None else "unreadable"
            if kind is not None:
                found[kind].append(Path(near(str(path))))
    if not any(found.values()):
        raise UsageError(f"{folder}: no scene, robot or graph file in this folder or its subfolders")
    return [(kind, path) for kind in ORDER for path in found[kind]]
