"""Verbs that consist of verbs, such as `graphrun topic echo`."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Protocol

from graphengine.cli import add_verb


class Subverb(Protocol):
    """A module with one of the verbs."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of the verb."""

    def execute(self, arguments: argparse.Namespace) -> int:
        """Execute the verb and return its exit code."""


def add_subverbs(parser: argparse.ArgumentParser, subverbs: Mapping[str, tuple[Subverb, str]]) -> None:
    """Add verbs to the parser of a verb; each has a module and a summary."""
    verbs = parser.add_subparsers(dest="subverb", metavar="VERB", required=True)
    for name, (module, summary) in subverbs.items():
        sub = add_verb(verbs, name, summary)
        module.add_arguments(sub)
        sub.set_defaults(execute_subverb=module.execute)


def execute(arguments: argparse.Namespace) -> int:
    """Execute the given verb and return its exit code."""
    return int(arguments.execute_subverb(arguments))
