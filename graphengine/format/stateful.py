"""Bases of objects whose state is part of checkpoints, and of shared objects."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, Self


class Shared:
    """An object that copies of a state refer to instead of copying it."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> Self:
        return self


class Stateful(Shared):
    """An object with a state that can be saved and restored; a subclass names the attributes of the state.

    A checkpoint holds a copy, so it can be restored any number of times.
    """

    __slots__ = ()

    kept: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that a checkpoint keeps; the others follow from them, or never change."""

    def save(self) -> Any:
        """A copy of the present state."""
        return copy.deepcopy([getattr(self, name) for name in self.kept])

    def restore(self, saved: Any) -> None:
        """Return to a saved state."""
        for name, value in zip(self.kept, copy.deepcopy(saved), strict=True):
            setattr(self, name, value)
