"""One attribute of a prim, and the numbers that one takes."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from graphengine.format.errors import ContextError
from graphengine.format.wording import shown


@dataclass(frozen=True, slots=True)
class Attribute:
    """One attribute of a prim.

    Attributes:
        type: as USD calls it.
        read: its value, as JSON has it.
        write: changes it; None where it cannot be changed while the simulation runs.
    """

    type: str
    read: Callable[[], Any]
    write: Callable[[Any], None] | None = None


def numbers(value: Any, count: int) -> list[float]:
    """Finite numbers of a JSON array.

    Raises:
        ContextError: it holds anything else.
    """
    if isinstance(value, list) and len(value) == count and all(type(number) in (int, float) for number in value):
        with contextlib.suppress(OverflowError):
            found = [float(number) for number in value]
            if all(map(math.isfinite, found)):
                return found
    what = "a finite number" if count == 1 else f"an array of {count} finite numbers"
    several = isinstance(value, list) and len(value) == count
    given = f"[{', '.join(map(shown, value))}]" if several and count > 1 else shown(value[0] if several else value)
    raise ContextError(f"it has to be {what}, not {given}", value)
