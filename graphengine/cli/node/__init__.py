"""`graphrun node`: inspect the nodes of a live network, with or without ROS installed, like `ros2 node`."""

from __future__ import annotations

from graphengine.cli.node import info, listing
from graphengine.cli.subverbs import execute, with_subverbs

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list the nodes"),
    "info": (info, "list the topics, services and actions of a node"),
}

add_arguments = with_subverbs(VERBS, "`graphrun nodes` lists the node types of graphs.")
