"""Helpers for verbs that have subverbs, such as `graphrun topic echo` and `graphrun topic list`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Mapping

from graphengine.cli.live import add_live_arguments
from graphengine.cli.parser import add_verb

Subverb = tuple[str, Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]
"""Summary of a subverb, the function that adds its arguments, and the function that executes it and returns the exit code."""


def add_subverbs(
    parser: argparse.ArgumentParser, subverbs: Mapping[str, Subverb], epilog: str | None = None
) -> dict[str, argparse.ArgumentParser]:
    """Add subverbs to the parser of a verb; return their parsers by name.

    Args:
        parser: parser of the verb.
        subverbs: the subverbs by name.
        epilog: text at the end of the verb's help.
    """
    parser.epilog = epilog
    verbs = parser.add_subparsers(dest="subverb", metavar="VERB", required=True)
    for name, (summary, add_arguments, execute) in subverbs.items():
        sub = add_verb(verbs, name, summary)
        add_arguments(sub)
        sub.set_defaults(function=execute)
    return dict(verbs.choices)


def add_live_subverbs(
    parser: argparse.ArgumentParser, subverbs: Mapping[str, Subverb], epilog: str, clocked: Collection[str] = ()
) -> None:
    """Add subverbs that join the network to the parser of a verb.

    Args:
        parser: parser of the verb.
        subverbs: the subverbs by name; the options for joining follow their arguments.
        epilog: text at the end of the verb's help.
        clocked: names of the subverbs with `--use-sim-time`.
    """
    for name, sub in add_subverbs(parser, subverbs, epilog).items():
        add_live_arguments(sub, clock=name in clocked)


def reach_of(peers: str) -> str:
    """Return a sentence for the help of a verb: which servers, or other `peers`, the verb reaches with each transport."""
    dds = f"--transport dds reaches only {peers} on Cyclone DDS"
    return f"{dds}; --transport rclpy reaches {peers} on the RMW of the sourced ROS 2."
