"""A parameter value with its source, which becomes a comment in the parameter file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Sourced(Generic[T]):
    """A parameter value, and the text of the comment that names the value's source."""

    value: T
    source: str


NAV2 = "Nav2's own parameter file"
"""Source of values without another source in a template, including defaults of Nav2's nodes."""
