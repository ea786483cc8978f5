"""`graphrun service`: list and call services on a live network, with or without ROS installed, like `ros2 service`."""

from __future__ import annotations

import argparse

from graphengine.cli.service import call, kind, listing
from graphengine.cli.subverbs import add_subverbs, execute, reach_of

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list services that have a server or client"),
    "type": (kind, "print the type of a service"),
    "call": (call, "send a request and print the response"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun service` to its parser."""
    parser.epilog = reach_of("servers")
    add_subverbs(parser, VERBS)
