"""`graphrun topic`: inspect topics of a live network, with or without ROS, like `ros2 topic`."""

from __future__ import annotations

import argparse

from graphengine.cli.subverbs import add_subverbs, execute
from graphengine.cli.topic import delay, echo, hz, info, listing, pub

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list topics that have a writer or reader"),
    "info": (info, "list the writers and readers of a topic with their quality of service"),
    "echo": (echo, "print messages of a topic as they arrive"),
    "hz": (hz, "measure the rate of messages"),
    "delay": (delay, "measure the age of messages on arrival, by the stamp in their header"),
    "pub": (pub, "publish messages"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic` to its parser."""
    parser.epilog = "`graphrun topics SCENE` lists the topics of a scene without running it."
    add_subverbs(parser, VERBS)
