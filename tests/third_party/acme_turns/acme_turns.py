"""Adds the verb `turns` to graphrun."""

from __future__ import annotations

import argparse
import math

import graphengine as ge

HELP = "print how often a wheel turns over a distance, within 0.1 %"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument("distance", metavar="DISTANCE", type=float, help="distance, m")
    parser.add_argument(
        "--radius", metavar="RADIUS", type=float, default=0.5, help="radius of the wheel, m (default 0.5)"
    )


def execute(arguments: argparse.Namespace) -> int:
    """Print the number of turns; return 0, or 3 for a distance below 0."""
    if arguments.radius <= 0.0:
        raise ge.UsageError(f"--radius {arguments.radius:g}: write a number above 0")
    turns = arguments.distance / (2.0 * math.pi * arguments.radius)
    print(f"{turns:.3f}")  # noqa: T201
    return 3 if turns < 0.0 else 0
