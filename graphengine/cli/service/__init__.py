"""`graphrun service`: list and call services on a live network, with or without ROS installed, like `ros2 service`."""

from __future__ import annotations

from graphengine.cli.service import call, kind, listing
from graphengine.cli.subverbs import execute, reach_of, with_subverbs

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list services that have a server or client"),
    "type": (kind, "print the type of a service"),
    "call": (call, "send a request and print the response"),
}

add_arguments = with_subverbs(VERBS, reach_of("servers"))
