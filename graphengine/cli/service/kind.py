"""`graphrun service type`: print the type of a service."""

from __future__ import annotations

import argparse

from graphengine.cli.live import Live, absolute, add_live_arguments, show
from graphengine.cli.service.listing import service_types


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun service type` to its parser."""
    parser.add_argument("service", metavar="SERVICE", help="service, such as /get_map")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the types of the service, one per line; return 0.

    Raises:
        TransportError: the service has no server or client.
    """
    service = absolute(arguments.service)
    with Live(arguments) as live:
        types = service_types(live.graph(lambda graph: service in service_types(graph)))
        if service not in types:
            raise live.unknown("service", service, types)
        show("\n".join(types[service]))
    return 0
