"""`graphrun param`: read and set parameters of nodes on a live network, with or without ROS installed, like `ros2 param`."""

from __future__ import annotations

from graphengine.cli.param import describe, dump, get, listing, load, set_value
from graphengine.cli.subverbs import execute, reach_of, with_subverbs

__all__ = ["add_arguments", "execute"]

VERBS = {
    "list": (listing, "list the parameters of a node, or of all nodes"),
    "get": (get, "print the value of a parameter"),
    "set": (set_value, "set a parameter"),
    "describe": (describe, "print the types, descriptions and limits of parameters"),
    "dump": (dump, "print all parameters of a node in the form of a YAML file"),
    "load": (load, "set the parameters of a node from a YAML file"),
}

add_arguments = with_subverbs(
    VERBS, f"A run offers the inputs of its nodes and the variables of its graphs as parameters. {reach_of('nodes')}"
)
