"""`graphrun action`: list actions of a live network and send goals, with or without ROS, like `ros2 action`."""

from __future__ import annotations

import argparse

from graphengine.cli import add_verb
from graphengine.cli.action import info, listing, send_goal

VERBS = {
    "list": (listing, "list actions that have a server or client"),
    "info": (info, "list the clients and servers of an action"),
    "send_goal": (send_goal, "send a goal and print its result"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.epilog = (
        "Embedded DDS reaches servers on Cyclone DDS only; --transport rclpy reaches those of the sourced RMW."
    )
    verbs = parser.add_subparsers(dest="action_verb", metavar="VERB", required=True)
    for name, (module, summary) in VERBS.items():
        sub = add_verb(verbs, name, summary)
        module.add_arguments(sub)
        sub.set_defaults(of_action=module.execute)


def execute(arguments: argparse.Namespace) -> int:
    """Execute the sub-verb and return its exit code."""
    return int(arguments.of_action(arguments))
