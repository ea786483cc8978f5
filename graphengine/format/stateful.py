"""Base classes of objects whose state a checkpoint keeps, and of handles to them."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, Self


class Shared:
    """An object that a copy of a state refers to, and does not copy."""

    __slots__ = ()

    def __deepcopy__(self, memo: object) -> Self:
        return self


class Stateful(Shared):
    """An object that can go back to an earlier state; a subclass names the attributes that make it up.

    What a checkpoint holds is a copy, so that the object goes on as it likes, and can go back any number of times.
    """

    __slots__ = ()

    kept: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that a checkpoint keeps; the others follow from them, or never change."""

    def save(self) -> Any:
        """A copy of the present state."""
        return copy.deepcopy([getattr(self, name) for name in self.kept])

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned."""
        for name, value in zip(self.kept, copy.deepcopy(saved), strict=True):
            setattr(self, name, value)
