"""Base classes for checkpoints: a `Stateful` object saves and restores its state, a `Shared` object is never copied."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, Self


class Shared:
    """Base class of objects that `copy.deepcopy` does not copy, so that a copied state refers to the same object."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> Self:
        return self


class Stateful(Shared):
    """Base class of objects whose state can be saved and restored; a subclass lists the attributes to save in `kept`."""

    __slots__ = ()

    kept: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that `save` copies; all other attributes are constant, or can be computed from these."""

    def save(self) -> Any:
        """Return a deep copy of the attributes in `kept`."""
        return copy.deepcopy([getattr(self, name) for name in self.kept])

    def restore(self, saved: Any) -> None:
        """Set the attributes in `kept` to copies of the saved values; a saved state can be restored any number of times."""
        for name, value in zip(self.kept, copy.deepcopy(saved), strict=True):
            setattr(self, name, value)
