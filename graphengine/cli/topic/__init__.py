"""`graphrun topic`: inspect topics of a live network, with or without ROS, like `ros2 topic`."""

from __future__ import annotations

import argparse

from graphengine.cli import add_verb
from graphengine.cli.topic import delay, echo, hz, info, listing, pub

VERBS = {
    "list": (listing, "list topics that have a writer or reader"),
    "info": (info, "list the writers and readers of a topic with their quality of service"),
    "echo": (echo, "print messages of a topic as they arrive"),
    "hz": (hz, "measure the rate of messages"),
    "delay": (delay, "measure the age of messages on arrival, by the stamp in their header"),
    "pub": (pub, "publish messages"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.epilog = "`graphrun topics SCENE` lists the topics of a scene without running it."
    verbs = parser.add_subparsers(dest="topic_verb", metavar="VERB", required=True)
    for name, (module, summary) in VERBS.items():
        sub = add_verb(verbs, name, summary)
        module.add_arguments(sub)
        sub.set_defaults(of_topic=module.execute)


def execute(arguments: argparse.Namespace) -> int:
    """Execute the sub-verb and return its exit code; 0 after Ctrl-C."""
    return int(arguments.of_topic(arguments))
