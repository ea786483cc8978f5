"""Values with their sources, which become the comments of a parameter file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Sourced(Generic[T]):
    """A value, and its source as a text for a comment."""

    value: T
    source: str


NAV2 = "Nav2's own parameter file"


def nav2(value: T) -> Sourced[T]:
    """Return a value whose source is Nav2's own parameter file, or a default of Nav2's nodes."""
    return Sourced(value, NAV2)
