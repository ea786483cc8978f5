"""A parameter value together with its source, which is written as a comment into the parameter file."""

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


def nav2(value: T) -> Sourced[T]:
    """Label a value as taken from Nav2's own parameter file, and return it; defaults of Nav2's nodes get this label too."""
    return Sourced(value, NAV2)
