"""`graphrun nav2`: drive the robots of a scene with Nav2."""

from __future__ import annotations

from graphengine.cli.nav2 import files, goals
from graphengine.cli.subverbs import execute, with_subverbs

__all__ = ["add_arguments", "execute"]

VERBS = {
    "files": (files, "write Nav2's parameters, map, launch file and RViz configuration for a scene"),
    "goals": (
        goals,
        "send goals to Nav2 one after another, and measure how well the robot reaches them, by its true pose",
    ),
}

add_arguments = with_subverbs(VERBS)
