"""`graphrun param dump`: print all parameters of a node as a YAML file."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from graphengine.cli.live import Live, add_live_arguments, show
from graphengine.cli.param.nodes import add_node_argument, client_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    add_node_argument(parser)
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the parameters; return 0."""
    import yaml

    from graphengine.messages.parameters import python_value

    with Live(arguments) as live:
        client = client_of(live, arguments.node)
        names = client.list()
        values = {name: python_value(value) for name, value in zip(names, client.get(names), strict=True)}
    show(yaml.dump({client.node: {"ros__parameters": nested(values)}}, default_flow_style=False))
    return 0


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with dotted names as nested mappings, one level for each part of a name."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *way, last = name.split(".")
        place = tree
        for part in way:
            place = place.setdefault(part, {})
        place[last] = value
    return tree
