"""Values that say where they come from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Sourced(Generic[T]):
    """A value and where it comes from."""

    value: T
    source: str


NAV2 = "Nav2's own parameter file"


def nav2(value: T) -> Sourced[T]:
    """Return a value of Nav2's own parameter file, or a default of its nodes."""
    return Sourced(value, NAV2)
