"""The entries of a robot file that will be written: the keys of each section, as `robot_spec` describes them, and comments."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Keys = dict[str, Any]
"""Keys of a `DriveSpec`, a `MaterialSpec` or another part of a robot file; compiling the written file checks them."""


@dataclass(slots=True)
class Entry:
    """A key of a section with its value, and the comments of the import on them.

    Attributes:
        value: keys and values, in the order in which they are written.
        comments: lines of the comment above the key.
        hint: comment after the value, on the same line.
    """

    value: Any
    comments: list[str] = field(default_factory=list)
    hint: str = ""


def material(friction: float, combine: str, bind: list[str], directed: Keys | None = None) -> Keys:
    """Return the keys of a material; `directed` are those of its friction across a direction, if it has one."""
    both = {"static_friction": friction, "dynamic_friction": friction}
    return {**both, **(directed or {}), "combine": combine, "bind": bind}
