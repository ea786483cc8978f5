"""`graphrun topic`: topics of a live network, with or without ROS, in the manner of `ros2 topic`."""

from __future__ import annotations

import argparse

from graphengine.cli.topic import delay, echo, hz, info, listing, pub

VERBS = {
    "list": (listing, "topics that somebody writes or reads"),
    "info": (info, "who writes and reads a topic, and with which quality of service"),
    "echo": (echo, "messages of a topic, as they come"),
    "hz": (hz, "how often messages come"),
    "delay": (delay, "how old messages are when they come, by the stamp of their header"),
    "pub": (pub, "publish messages"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    parser.epilog = "What a scene will say and hear is told without running it by `graphrun topics SCENE`."
    verbs = parser.add_subparsers(dest="topic_verb", metavar="VERB", required=True)
    for name, (module, summary) in VERBS.items():
        sub = verbs.add_parser(name, help=summary, description=f"{summary[0].upper()}{summary[1:]}.")
        module.add_arguments(sub)
        sub.set_defaults(of_topic=module.execute)


def execute(arguments: argparse.Namespace) -> int:
    """What the verb below says; 0 when it was ended by Ctrl-C."""
    return int(arguments.of_topic(arguments))
