"""`graphrun export`: convert a graph to a script that builds it in Isaac Sim."""

from __future__ import annotations

import argparse
from pathlib import Path

from graphengine.cli.common import add_file_arguments, clean, open_scene, print_findings, refuse_to_overwrite
from graphengine.cli.options import add_flag, add_value
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import Findings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun export` to its parser."""
    add_file_arguments(parser)
    form = "format of the output; isaac-script: Python script for Isaac Sim (default)"
    parser.add_argument("--to", choices=("isaac-script",), default="isaac-script", help=form)
    add_value(parser, "--output", "FILE", "script to write (default: print the script)", short="-o", type=Path)
    add_flag(parser, "--force", "overwrite an existing file")
    strict = "write no script if Isaac Sim lacks nodes or ports of the graph (default: write them as comments)"
    add_flag(parser, "--strict", strict)


def execute(arguments: argparse.Namespace) -> int:
    """Write the script.

    Returns:
        0 on success. 1 if the file has errors or several graphs, or, with `--strict`, if Isaac Sim lacks nodes or ports of the
        graph; each reason is reported.
    """
    from graphengine.api.scene import loaded_of
    from graphengine.isaac.export import write_script

    output = arguments.output
    refuse_to_overwrite([output] if output is not None else [], force=arguments.force)
    scene = open_scene(arguments)
    findings = Findings()
    graphs = loaded_of(scene).planned
    if len(graphs) != 1:
        findings.add("G402", f"{arguments.file!r} has {len(graphs)} graphs; export each graph from its own file")
    script = write_script(graphs[0], findings, strict=arguments.strict) if graphs else ""
    print_findings(findings, notes=False)
    if findings.errors:
        return 1
    if output is None:
        print(script, end="")
    else:
        write_together({output: script.encode()})
        print(clean(f"wrote {output}"))
    return 0
