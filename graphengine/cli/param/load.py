"""`graphrun param load`: set the parameters of a node from a YAML file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from graphengine.cli.live import Live, add_live_arguments
from graphengine.cli.param.nodes import add_node_argument, client_of
from graphengine.format.errors import UsageError

EVERY_NODE = "/**"
"""Key of a parameter file whose parameters apply to all nodes."""
KEY = "ros__parameters"
_BATCH = 500
"""Maximum number of parameters in one request."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param load` to its parser."""
    add_node_argument(parser)
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="YAML file in the form that `graphrun param dump` prints"
    )
    wildcard = f"ignore the parameters below {EVERY_NODE}, which are for all nodes"
    parser.add_argument("--no-use-wildcard", action="store_true", help=wildcard)
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Set the parameters; return 0, or 1 if the node refuses one."""
    from graphengine.cli.param.set_value import given, report

    values = read(arguments.file, wildcard=not arguments.no_use_wildcard)
    with Live(arguments) as live:
        client = client_of(live, arguments.node)
        code, names = 0, list(values)
        for first in range(0, len(names), _BATCH):
            batch = names[first : first + _BATCH]
            results = client.set([given(name, values[name], str(values[name])) for name in batch])
            for name, result in zip(batch, results, strict=True):
                code |= report(result, f"Set parameter {name} successful", f"Set parameter {name} failed")
    return code


def read(path: Path, *, wildcard: bool) -> Mapping[str, Any]:
    """Return the values in a parameter file by parameter name, without nulls. As in ros2, the file's node names are ignored.

    Args:
        path: the file.
        wildcard: include the parameters below `/**`.

    Raises:
        CheckError: the file is not YAML.
        UsageError: the file has no parameters, or a list whose elements have different types.
    """
    from graphengine.format import document
    from graphengine.format.diagnostics import Findings
    from graphengine.messages.parameters import ParameterType, fitting_type

    findings = Findings()
    found = document.load(path, findings)
    findings.raise_errors()
    data = found.data if found is not None else None
    nodes = data if isinstance(data, dict) else {}
    order = ([EVERY_NODE] if wildcard else []) + [node for node in nodes if node != EVERY_NODE]
    values: dict[str, Any] = {}
    for node in order:
        given = nodes.get(node)
        if isinstance(given, dict) and isinstance(given.get(KEY), dict):
            values |= {name: value for name, value in flat(given[KEY]) if value is not None}
    if not values:
        raise UsageError(f"{path}: no parameters; write them below NODE: {KEY}:")
    for name, value in values.items():
        if isinstance(value, list) and fitting_type(value) is ParameterType.NOT_SET:
            legal = "write only booleans, only integers, only numbers or only texts"
            raise UsageError(f"{path}: {name} is not a list of values of one type; {legal}")
    return values


def flat(tree: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted name and the value of each leaf of nested mappings; names begin with the prefix `above`."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value
