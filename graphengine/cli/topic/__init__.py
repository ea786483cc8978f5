"""`graphrun topic`: inspect topics on a live network, with or without ROS installed, like `ros2 topic`."""

from __future__ import annotations

from graphengine.cli.subverbs import execute, with_subverbs
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

add_arguments = with_subverbs(VERBS, "`graphrun topics SCENE` lists the topics of a scene without running it.")
