"""`graphrun service list`: list services."""

from __future__ import annotations

import argparse

from graphengine.cli.live import Live, add_live_arguments, is_hidden
from graphengine.ros.network_graph import NetworkGraph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun service list` to its parser."""
    parser.add_argument("-t", "--show-types", action="store_true", help="also print the type of each service")
    parser.add_argument("-c", "--count-services", action="store_true", help="print only the number of services")
    hidden = "include services with a name part that begins with _, such as those of actions"
    parser.add_argument("--include-hidden-services", action="store_true", help=hidden)
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the services; return 0, also if there are none."""
    with Live(arguments) as live:
        types = service_types(live.graph())
        services = [name for name in types if arguments.include_hidden_services or not is_hidden(name)]
        lines = [name + (f" [{', '.join(types[name])}]" if arguments.show_types else "") for name in services]
        live.show_found("services", len(services), lines, counted=arguments.count_services)
    return 0


def service_types(graph: NetworkGraph) -> dict[str, list[str]]:
    """Return the types of each service by its name."""
    types: dict[str, list[str]] = {}
    for name, kind in graph.services:
        types.setdefault(name, []).append(kind)
    return types
