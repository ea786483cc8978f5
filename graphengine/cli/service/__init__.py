"""`graphrun service`: list and call services on a live network, with or without ROS installed, like `ros2 service`."""

from __future__ import annotations

import argparse

from graphengine.cli.service import call, kind, listing
from graphengine.cli.subverbs import add_subverbs, execute

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list services that have a server or client"),
    "type": (kind, "print the type of a service"),
    "call": (call, "send a request and print the response"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun service` to its parser."""
    parser.epilog = (
        "--transport dds reaches only servers on Cyclone DDS; --transport rclpy reaches servers on the RMW of the sourced"
        " ROS 2."
    )
    add_subverbs(parser, VERBS)
