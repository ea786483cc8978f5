"""`graphrun param list`: list parameters."""

from __future__ import annotations

import argparse
import re
import sys

from graphengine.cli.common import clean
from graphengine.cli.live import Live, add_live_arguments, is_hidden, show
from graphengine.cli.param.nodes import add_node_argument, client_of, nodes_with_parameters
from graphengine.format.errors import TransportError, UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param list` to its parser."""
    add_node_argument(parser, optional=True)
    parser.add_argument(
        "--filter", metavar="REGEX", help="list only parameters whose name begins with a match of this expression"
    )
    parser.add_argument("--include-hidden-nodes", action="store_true", help="include nodes whose name begins with _")
    prefixes = "list only parameters with these prefixes, such as cmd_vel.DiffController"
    parser.add_argument("--param-prefixes", metavar="PREFIX", nargs="+", default=[], help=prefixes)
    parser.add_argument("--param-type", action="store_true", help="also print the type of each parameter")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the parameters; return 0, or 1 if a node does not answer."""
    from graphengine.cli.param.describe import type_name
    from graphengine.ros.parameter_client import ParameterClient

    try:
        wanted = re.compile(arguments.filter or "")
    except re.error as error:
        raise UsageError(f"--filter {arguments.filter}: {error}") from None
    code = 0
    with Live(arguments) as live:
        if arguments.node:
            clients = [client_of(live, arguments.node)]
        else:
            nodes = nodes_with_parameters(live.graph())
            nodes = [node for node in nodes if arguments.include_hidden_nodes or not is_hidden(node)]
            clients = [ParameterClient(live.transport, node, live.definitions) for node in nodes]
        for client in clients:
            try:
                names = [name for name in client.list(arguments.param_prefixes) if wanted.match(name)]
                kinds = client.describe(names) if arguments.param_type else ()
            except TransportError as error:
                print(clean(f"error: {error}"), file=sys.stderr)
                code = 1
                continue
            types = {each.name: f" (type: {type_name(each.type)})" for each in kinds}
            lines = [f"  {name}{types.get(name, '')}" for name in names]
            if lines:
                show("\n".join(lines if arguments.node else [f"{client.node}:", *lines]))
        if not clients:
            live.say_none("nodes with parameters")
    return code
