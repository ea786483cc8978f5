"""`graphrun node info`: print the topics, services and actions of a node."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable

from graphengine.cli.action.listing import FEEDBACK
from graphengine.cli.live import Live, absolute, add_live_arguments, is_hidden, show
from graphengine.cli.node.listing import node_names
from graphengine.ros.network_graph import Direction, NetworkGraph

Named = tuple[str, str]
"""Name and type of a topic, service or action."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun node info` to its parser."""
    parser.add_argument("node", metavar="NODE", help="node, such as /graphengine")
    parser.add_argument(
        "--include-hidden",
        action="store_true",
        help="include topics, services and actions with a name part that begins with _",
    )
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the topics, services and actions of the node; return 0.

    Raises:
        TransportError: there is no such node.
    """
    node = absolute(arguments.node)
    with Live(arguments) as live:
        graph = live.graph(names=True)
        names = node_names(graph, hidden=arguments.include_hidden)
        if node not in names:
            raise live.unknown("node", node, names)
        if (number := names.count(node)) > 1:
            print(f"WARNING: {number} nodes have the name {node!r}; the lists below merge them", file=sys.stderr)
        sections = _sections(graph, node)
        show(node)
        for title, found in sections.items():
            shown = (
                sorted(found) if arguments.include_hidden else sorted(pair for pair in found if not is_hidden(pair[0]))
            )
            show("\n".join((f"  {title}:", _lines(shown))))
    return 0


def _sections(graph: NetworkGraph, node: str) -> dict[str, set[Named]]:
    """Return the topics, services and actions of a node by section, with the titles and the order of `ros2 node info`."""
    heard, said = _topics(graph, node, "subscribe"), _topics(graph, node, "publish")
    same = [other for other in graph.nodes if other.name == node]
    return {
        "Subscribers": heard,
        "Publishers": said,
        "Service Servers": {pair for other in same for pair in other.servers},
        "Service Clients": {pair for other in same for pair in other.clients},
        "Action Servers": _actions(said),
        "Action Clients": _actions(heard),
    }


def _topics(graph: NetworkGraph, node: str, direction: Direction) -> set[Named]:
    ends = (end for end in graph.endpoints if end.full_node == node and end.direction == direction)
    return {(end.topic, end.message_type) for end in ends}


def _actions(topics: Iterable[Named]) -> set[Named]:
    """Return name and type of the actions whose feedback topic is among `topics`, which are pairs of name and type.

    A server publishes the feedback topic, and a client subscribes to it. So the topics that a node publishes give its action
    servers, and the topics that it subscribes to give its action clients.
    """
    return {
        (topic.removesuffix(FEEDBACK), kind.removesuffix("_FeedbackMessage"))
        for topic, kind in topics
        if topic.endswith(FEEDBACK)
    }


def _lines(pairs: Iterable[Named]) -> str:
    """Return one line of text for each name, with all its types."""
    types: dict[str, list[str]] = {}
    for name, kind in pairs:
        types.setdefault(name, []).append(kind)
    return "\n".join(f"    {name}: {', '.join(kinds)}" for name, kinds in types.items())
