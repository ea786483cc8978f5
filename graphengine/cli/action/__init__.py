"""`graphrun action`: list actions of a live network and send goals, with or without ROS, like `ros2 action`."""

from __future__ import annotations

import argparse

from graphengine.cli.action import info, listing, send_goal
from graphengine.cli.subverbs import add_subverbs, execute

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list actions that have a server or client"),
    "info": (info, "list the clients and servers of an action"),
    "send_goal": (send_goal, "send a goal and print its result"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun action` to its parser."""
    parser.epilog = (
        "Embedded DDS reaches servers on Cyclone DDS only; --transport rclpy reaches those of the sourced RMW."
    )
    add_subverbs(parser, VERBS)
