"""`graphrun node`: inspect the nodes of a live network, with or without ROS installed, like `ros2 node`."""

from __future__ import annotations

import argparse
import sys

from graphengine.cli.live import Live, absolute, actions_of, is_hidden, show, types_by_name
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.subverbs import add_live_subverbs
from graphengine.ros.network_graph import Direction, NetworkGraph

Named = tuple[str, str]
"""Name and type of a topic, service or action."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    subverbs = {
        "list": ("list the nodes", _list_arguments, _list),
        "info": ("list the topics, services and actions of a node", _info_arguments, _info),
    }
    add_live_subverbs(parser, subverbs, "`graphrun nodes` lists the node types of graphs.")


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_flag(parser, "--all", "include nodes whose name begins with _", short="-a")
    add_flag(parser, "--count-nodes", "print only the number of nodes", short="-c")


def _list(arguments: argparse.Namespace) -> int:
    """Print the nodes; return 0, also if there are none."""
    with Live(arguments) as live:
        names = node_names(live.graph(names=True), hidden=arguments.all)
        if len(set(names)) < len(names) and not arguments.count_nodes:
            print("WARNING: some nodes have the same name; this can have unintended effects", file=sys.stderr)
        live.show_found("nodes", len(names), names, counted=arguments.count_nodes)
    return 0


def node_names(graph: NetworkGraph, hidden: bool) -> list[str]:
    """Return the full name of each node, sorted, with repetitions; names of hidden nodes only if `hidden` is set."""
    names = (node.name for node in graph.nodes)
    return [name for name in names if hidden or not name.rpartition("/")[2].startswith("_")]


def _info_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "node", "NODE", "node, such as /graphengine")
    add_flag(parser, "--include-hidden", "include topics, services and actions with a name part that begins with _")


def _info(arguments: argparse.Namespace) -> int:
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
            shown = sorted(pair for pair in found if arguments.include_hidden or not is_hidden(pair[0]))
            lines = "\n".join(f"    {name}: {', '.join(kinds)}" for name, kinds in types_by_name(shown).items())
            show(f"  {title}:\n{lines}")
    return 0


def _sections(graph: NetworkGraph, node: str) -> dict[str, set[Named]]:
    """Return a dict from the titles of `ros2 node info`, in its order, to the topics, services and actions of a node."""
    heard, said = _topics(graph, node, "subscribe"), _topics(graph, node, "publish")
    same = [other for other in graph.nodes if other.name == node]
    return {
        "Subscribers": heard,
        "Publishers": said,
        "Service Servers": {pair for other in same for pair in other.servers},
        "Service Clients": {pair for other in same for pair in other.clients},
        "Action Servers": actions_of(said),  # a server publishes the feedback topic
        "Action Clients": actions_of(heard),
    }


def _topics(graph: NetworkGraph, node: str, direction: Direction) -> set[Named]:
    ends = (end for end in graph.endpoints if end.full_node == node and end.direction == direction)
    return {(end.topic, end.message_type) for end in ends}
