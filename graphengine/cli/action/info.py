"""`graphrun action info`: print the clients and servers of an action."""

from __future__ import annotations

import argparse

from graphengine.cli.action.listing import FEEDBACK, action_types
from graphengine.cli.live import Live, absolute, add_live_arguments, show


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun action info` to its parser."""
    parser.add_argument("action", metavar="ACTION", help="action, such as /fibonacci")
    parser.add_argument("-t", "--show-types", action="store_true", help="also print the type of each client and server")
    parser.add_argument("-c", "--count", action="store_true", help="print only the number of clients and servers")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the clients and servers of the action; return 0.

    Raises:
        TransportError: the action has no client or server.
    """
    action = absolute(arguments.action)
    with Live(arguments) as live:
        graph = live.graph(names=not arguments.count)
        known = action_types(graph)
        if action not in known:
            raise live.unknown("action", action, known)
        show(f"Action: {action}")
        for what, ends in (
            ("clients", graph.subscribers(action + FEEDBACK)),
            ("servers", graph.publishers(action + FEEDBACK)),
        ):
            show(f"Action {what}: {len(ends)}")
            for end in () if arguments.count else ends:
                kind = f" [{end.message_type.removesuffix('_FeedbackMessage')}]" if arguments.show_types else ""
                show(f"    {end.full_node or '_NODE_NAME_UNKNOWN_'}{kind}")
    return 0
