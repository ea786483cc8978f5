"""`graphrun topic`: inspect topics on a live network, with or without ROS installed, like `ros2 topic`."""

from __future__ import annotations

import argparse

from graphengine.cli.subverbs import add_subverbs, execute
from graphengine.cli.topic import delay, echo, hz, info, listing, pub

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list topics that have a publisher or subscriber"),
    "info": (info, "print the type of a topic and its numbers of publishers and subscribers, or with -v all details"),
    "echo": (echo, "print the messages of a topic as they arrive"),
    "hz": (hz, "measure the rate of the messages of a topic"),
    "delay": (delay, "measure the age of messages on arrival, from the stamp in their header"),
    "pub": (pub, "publish messages on a topic"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topic` to its parser."""
    parser.epilog = "`graphrun topics SCENE` lists the topics of a scene without running it."
    add_subverbs(parser, VERBS)
