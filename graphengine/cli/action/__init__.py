"""`graphrun action`: list actions and send goals on a live network, with or without ROS installed, like `ros2 action`."""

from __future__ import annotations

import argparse

from graphengine.cli.action import info, listing, send_goal
from graphengine.cli.subverbs import add_subverbs, execute, reach_of

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list actions that have a server or client"),
    "info": (info, "list the clients and servers of an action"),
    "send_goal": (send_goal, "send a goal and print its result"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun action` to its parser."""
    parser.epilog = reach_of("servers")
    add_subverbs(parser, VERBS)
