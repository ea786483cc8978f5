"""Adds options to the parsers of verbs."""

from __future__ import annotations

import argparse
from typing import Any


def add_flag(parser: argparse._ActionsContainer, option: str, what: str, short: str | None = None, **more: Any) -> None:
    """Add an option without a value. It is False unless the option, or its short form such as `-v`, is given."""
    parser.add_argument(*filter(None, (short, option)), action="store_true", help=what, **more)


def add_repeatable(parser: argparse._ActionsContainer, option: str, metavar: str, what: str, **more: Any) -> None:
    """Add an option that may be repeated; its value is the list of all given values."""
    parser.add_argument(option, metavar=metavar, action="append", default=[], help=f"{what}; may be repeated", **more)
