"""Adds the arguments NODE and PARAMETER to parsers, and finds nodes with parameters on a live network."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from graphengine.cli.live import Live, absolute
from graphengine.format.errors import TransportError
from graphengine.format.wording import did_you_mean, listing
from graphengine.ros.network_graph import NetworkGraph

if TYPE_CHECKING:
    from graphengine.ros.parameter_client import ParameterClient

_LIST = "list_parameters"


def add_node_argument(parser: argparse.ArgumentParser, *, optional: bool = False) -> None:
    """Add the positional argument NODE; `optional` allows it to be left out for all nodes."""
    text = "node, such as /dd100_0000/dd100" + (" (default: all nodes)" if optional else "")
    parser.add_argument("node", metavar="NODE", nargs="?" if optional else None, help=text)


def add_parameter_argument(parser: argparse.ArgumentParser) -> None:
    """Add the positional argument PARAMETER."""
    parser.add_argument("parameter", metavar="PARAMETER", help="name, such as cmd_vel.DiffController.maxLinearSpeed")


def nodes_with_parameters(graph: NetworkGraph) -> list[str]:
    """Return the full names of the nodes that offer parameters, sorted."""
    from graphengine.messages.parameters import SERVICES

    return [name.removesuffix(f"/{_LIST}") for name, kind in graph.services if kind == SERVICES[_LIST]]


def client_of(live: Live, given: str) -> ParameterClient:
    """Return a client of a node's parameters.

    Args:
        live: connection to the network.
        given: name of the node, with or without the leading slash.

    Raises:
        TransportError: there is no such node, or it has no parameters.
    """
    from graphengine.ros.parameter_client import ParameterClient

    node = absolute(given)
    graph = live.graph(lambda graph: node in nodes_with_parameters(graph))
    known = nodes_with_parameters(graph)
    if node not in known:
        near = did_you_mean(node, known) or listing(known, "nodes with parameters")
        raise TransportError(f"no node {node!r} with parameters\n{near}\nsearched {live.where}")
    return ParameterClient(live.transport, node, live.definitions)
