"""Prints the warnings of loggers, whose texts can come from strangers, without control characters."""

from __future__ import annotations

import logging

from graphengine.cli.common import clean

LONGEST = 2000
"""Maximum length of a printed message with its traceback, characters."""


class _Cleaned(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        text = super().format(record)
        return clean(text if len(text) <= LONGEST else f"{text[:LONGEST]}…")


def print_logs() -> None:
    """Print warnings and errors of all loggers, also those of other packages, to standard error.

    Without a handler of the root logger, Python would print them as they are. Handlers of a program that calls `main` stay.
    """
    handler = logging.StreamHandler()
    handler.setLevel(logging.WARNING)
    handler.setFormatter(_Cleaned())
    logging.basicConfig(handlers=[handler])
