"""`graphrun node`: inspect the nodes of a live network, with or without ROS installed, like `ros2 node`."""

from __future__ import annotations

import argparse

from graphengine.cli.node import info, listing
from graphengine.cli.subverbs import add_subverbs, execute

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list the nodes"),
    "info": (info, "list the topics, services and actions of a node"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun node` to its parser."""
    parser.epilog = "`graphrun nodes` lists the node types of graphs."
    add_subverbs(parser, VERBS)
