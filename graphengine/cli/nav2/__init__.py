"""`graphrun nav2`: drive the robots of a scene with Nav2."""

from __future__ import annotations

import argparse

from graphengine.cli.nav2 import files, goals
from graphengine.cli.subverbs import add_subverbs, execute

__all__ = ["add_arguments", "execute"]

VERBS = {
    "files": (files, "write Nav2's parameters, map, launch file and RViz configuration for a scene"),
    "goals": (
        goals,
        "send goals to Nav2 one after another, and measure how well the robot reaches them, by its true pose",
    ),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun nav2` to its parser."""
    add_subverbs(parser, VERBS)
