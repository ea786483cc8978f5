"""Answers as a process that was taken over sends them: a real one with one part of it made hostile."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from typing import Any

DEEP: list[Any] = []
for _ in range(300):
    DEEP = [DEEP]
HOSTILE: list[Any] = [
    *(None, True, 0, -1, 1 << 31, 10**4000, -1.5, 1e400, -1e400, float("nan")),
    *("", "\0", "\ud800", "\x1b[2J", "n" * 300, "a/" * 5000, "loop", "/etc/passwd", "..", "a\n  b: evil"),
    *([], {}, [None], {"": ""}, DEEP, ["x"] * 5000, {"path": 1}),
]


def forged(answer: bytes, count: int) -> Iterator[bytes]:
    """Such answers, the same ones each time."""
    dice = random.Random(1)
    for _ in range(count):
        data = json.loads(answer)
        parts = list(_parts(data))
        holder, key = dice.choice(parts)
        other, known = dice.choice(parts)
        match dice.randrange(4):
            case 0:
                holder[key] = other[known]
            case 1 if isinstance(holder, dict):
                holder[dice.choice(["\0", "forged", "n" * 300])] = holder.pop(key)
            case 2 if isinstance(holder, list):
                holder *= 50
            case _:
                holder[key] = dice.choice(HOSTILE)
        try:
            yield json.dumps(data).encode()
        except ValueError:  # it holds itself
            yield answer[: dice.randrange(len(answer))]


def _parts(data: Any) -> Iterator[tuple[Any, Any]]:
    """Every place in an answer: what holds it, and its key there."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, item in list(items):
        yield data, key
        yield from _parts(item)
