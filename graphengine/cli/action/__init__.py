"""`graphrun action`: list actions and send goals on a live network, with or without ROS installed, like `ros2 action`."""

from __future__ import annotations

from graphengine.cli.action import info, listing, send_goal
from graphengine.cli.subverbs import execute, reach_of, with_subverbs

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list actions that have a server or client"),
    "info": (info, "list the clients and servers of an action"),
    "send_goal": (send_goal, "send a goal and print its result"),
}

add_arguments = with_subverbs(VERBS, reach_of("servers"))
