"""Helpers for verbs that have subverbs, such as `graphrun topic echo` and `graphrun topic list`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Protocol

from graphengine.cli import add_verb


class Subverb(Protocol):
    """Interface of the module of a subverb, such as `graphengine.cli.topic.echo`."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the command-line arguments of the subverb to its parser."""

    def execute(self, arguments: argparse.Namespace) -> int:
        """Execute the subverb and return its exit code."""


def with_subverbs(
    subverbs: Mapping[str, tuple[Subverb, str]], epilog: str | None = None
) -> Callable[[argparse.ArgumentParser], None]:
    """Return the function `add_arguments` of a verb that has subverbs.

    Args:
        subverbs: module and summary of each subverb by its name.
        epilog: text at the end of the verb's help.
    """

    def add_arguments(parser: argparse.ArgumentParser) -> None:
        parser.epilog = epilog
        verbs = parser.add_subparsers(dest="subverb", metavar="VERB", required=True)
        for name, (module, summary) in subverbs.items():
            sub = add_verb(verbs, name, summary)
            module.add_arguments(sub)
            sub.set_defaults(execute_subverb=module.execute)

    return add_arguments


def reach_of(peers: str) -> str:
    """Return the sentence that says which peers a verb reaches with each transport, for its help."""
    dds = f"--transport dds reaches only {peers} on Cyclone DDS"
    return f"{dds}; --transport rclpy reaches {peers} on the RMW of the sourced ROS 2."


def execute(arguments: argparse.Namespace) -> int:
    """Execute the subverb that the user gave and return its exit code."""
    return int(arguments.execute_subverb(arguments))
