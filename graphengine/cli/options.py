"""Adds arguments to the parsers of verbs."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any


def add_flag(parser: argparse._ActionsContainer, option: str, what: str, short: str | None = None, **more: Any) -> None:
    """Add an option without a value, and its short form such as `-v`; the attribute is True if the user gives one of them."""
    parser.add_argument(*filter(None, (short, option)), action="store_true", help=what, **more)


def add_value(
    parser: argparse._ActionsContainer, name: str, metavar: str, what: str, short: str | None = None, **more: Any
) -> None:
    """Add an argument with a value: an option such as `--rate` with its short form, or the positional argument `name`."""
    parser.add_argument(*filter(None, (short, name)), metavar=metavar, help=what, **more)


def split_arguments(parser: argparse.ArgumentParser, split: Callable[[list[str]], tuple[list[str], list[str]]]) -> None:
    """Let a function split the words after a verb: the parser parses the first list; the second one goes to `arguments`."""
    parse = parser.parse_known_args

    def parse_first(given: Sequence[str], namespace: argparse.Namespace) -> tuple[argparse.Namespace, list[str]]:
        words, others = split(list(given))
        parsed, unknown = parse(words, namespace)
        parsed.arguments = [*parsed.arguments, *others]
        return parsed, unknown

    parser.parse_known_args = parse_first  # type: ignore[method-assign, assignment]


def add_repeatable(parser: argparse._ActionsContainer, option: str, metavar: str, what: str, **more: Any) -> None:
    """Add an option that the user may repeat; the attribute is the list of all given values."""
    parser.add_argument(option, metavar=metavar, action="append", default=[], help=f"{what}; may be repeated", **more)
