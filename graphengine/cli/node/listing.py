"""`graphrun node list`: list nodes."""

from __future__ import annotations

import argparse
import sys

from graphengine.cli.live import Live, add_live_arguments
from graphengine.ros.network_graph import NetworkGraph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun node list` to its parser."""
    parser.add_argument("-a", "--all", action="store_true", help="include nodes whose name begins with _")
    parser.add_argument("-c", "--count-nodes", action="store_true", help="print only the number of nodes")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the nodes; return 0, also if there are none."""
    with Live(arguments) as live:
        names = node_names(live.graph(names=True), hidden=arguments.all)
        if len(set(names)) < len(names) and not arguments.count_nodes:
            print("WARNING: some nodes have the same name; this can have unintended effects", file=sys.stderr)
        live.show_found("nodes", len(names), names, counted=arguments.count_nodes)
    return 0


def node_names(graph: NetworkGraph, hidden: bool) -> list[str]:
    """Return the full names of all nodes, sorted; hidden ones only if `hidden` is set. Nodes with equal names are all listed."""
    names = (node.name for node in graph.nodes)
    return [name for name in names if hidden or not name.rpartition("/")[2].startswith("_")]
