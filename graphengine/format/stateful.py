"""Base classes of objects whose state is saved in checkpoints, and of objects that all checkpoints share."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, Self


class Shared:
    """Base of objects that `copy.deepcopy` does not copy: all copies of a state refer to the same object."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> Self:
        return self


class Stateful(Shared):
    """An object with a state that can be saved and restored; a subclass lists the attributes of the state in `kept`.

    A checkpoint is a copy of the state, so it can be restored any number of times.
    """

    __slots__ = ()

    kept: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that a checkpoint contains; all others are derived from these or constant."""

    def save(self) -> Any:
        """Return a copy of the current state."""
        return copy.deepcopy([getattr(self, name) for name in self.kept])

    def restore(self, saved: Any) -> None:
        """Return to a saved state."""
        for name, value in zip(self.kept, copy.deepcopy(saved), strict=True):
            setattr(self, name, value)
