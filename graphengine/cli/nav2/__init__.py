"""`graphrun nav2`: drive the robots of a scene with Nav2."""

from __future__ import annotations

import argparse

from graphengine.cli.nav2 import files, goals
from graphengine.cli.subverbs import add_subverbs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    write = "write Nav2's parameters, map, launch file and RViz configuration for a scene"
    send = "send goals to Nav2 one after another, and measure how well the robot reaches them, by its true pose"
    subverbs = {
        "files": (write, files.add_arguments, files.execute),
        "goals": (send, goals.add_arguments, goals.execute),
    }
    add_subverbs(parser, subverbs)
