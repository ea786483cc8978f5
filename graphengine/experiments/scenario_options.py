"""The options of scenarios that `graphrun test` and the pytest plugin share."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path


def add_scenario_options(add: Callable[..., object]) -> None:
    """Add the options; `add` is `add_argument` of a parser of argparse, or `addoption` of one of pytest."""
    shard = "run only this part of all cases, as 3/8 for the third of eight parts"
    add("--shard", metavar="NUMBER/TOTAL", help=shard)
    again = "run each failed case with the same seed until it has run N times, and say how often it failed"
    add("--rerun", metavar="N", type=whole, help=again)
    bag = "judge the expectations over the topics of this recording, of a robot or a simulator; nothing is simulated"
    add("--bag", metavar="FILE", type=Path, help=bag)
    kept = "keep a recording, an HTML page, a picture and a report of each run that does not pass in this folder"
    add("--record-failures", metavar="DIR", type=Path, help=kept)
    add("--allow-programs", action="store_true", help="let scenarios start programs (`start:`)")


def whole(text: str) -> int:
    """Return a positive whole number of the command line."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"expected a number of at least 1, got {text!r}")
    return int(text)
