"""The result of a cell of the interop matrix."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Result:
    """What became of a cell: its figures, or why it failed."""

    row: str
    kind: str
    rmw: str
    works: bool
    text: str
    told: bool = False
    """Whether a user was told what to do instead."""
