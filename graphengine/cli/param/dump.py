"""`graphrun param dump`: print all parameters of a node in the form of a YAML file."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graphengine.cli.live import Live, add_live_arguments, show
from graphengine.cli.param.nodes import add_node_argument, client_of

if TYPE_CHECKING:
    from graphengine.ros.parameter_client import ParameterClient


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param dump` to its parser."""
    add_node_argument(parser)
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the parameters as YAML; return 0."""
    import yaml

    with Live(arguments) as live:
        client = client_of(live, arguments.node)
        values = current(client)
    show(yaml.dump({client.node: {"ros__parameters": nested(values)}}, default_flow_style=False))
    return 0


def current(client: ParameterClient) -> dict[str, Any]:
    """Return the values of a node's parameters by name; parameters without a value are left out."""
    from graphengine.messages.parameters import python_value

    names = client.list()
    answers = [client.get(names)]
    if len(answers[0]) != len(names):  # as one of them has no value
        answers = [client.get([name])[:1] for name in names]
        names = [name for name, answer in zip(names, answers, strict=True) if answer]
    found = [python_value(value) for answer in answers for value in answer]
    return {name: value for name, value in zip(names, found, strict=True) if value is not None}


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with dotted names as nested mappings. If `a` has a value too, `a.b` stays one key."""
    tree: dict[str, Any] = {}
    for name in sorted(values):
        place, rest = tree, name
        while "." in rest:
            part, _, below = rest.partition(".")
            inner = place.setdefault(part, {})
            if not isinstance(inner, dict):
                break
            place, rest = inner, below
        place[rest] = values[name]
    return tree
