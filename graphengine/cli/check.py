"""`graphrun check`: every mistake of every file, at once."""

from __future__ import annotations

import argparse
import sys


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    from graphengine.cli.common import add_file_arguments

    add_file_arguments(parser, many=True)
    parser.add_argument("--strict", action="store_true", help="warnings count as errors")
    parser.add_argument("--format", choices=("text", "json"), default="text", help="for people, or for programs")


def execute(arguments: argparse.Namespace) -> int:
    """0 without errors, 1 with."""
    from graphengine import build
    from graphengine.cli.common import counted, find_file, make_options, print_findings
    from graphengine.diagnostics import Findings, to_json

    options = make_options(arguments)
    findings = Findings()
    graphs = 0
    for name in arguments.files:
        assembly = build.assemble(find_file(name), options)
        graphs += len(assembly.graphs)
        findings.items += [item for item in assembly.findings.items if item not in findings.items]
        assembly.world.close()
    errors, warnings = len(findings.errors), len(findings.warnings)
    if arguments.format == "json":
        print(to_json(findings.sorted()))
    else:
        print_findings(findings, stream=sys.stdout)
        read = f"{counted(len(arguments.files), 'file')}, {counted(graphs, 'graph')}"
        print(f"{read}: {counted(errors, 'error')}, {counted(warnings, 'warning')}")
    return 1 if errors or (arguments.strict and warnings) else 0
