"""Faults of sensors and topics, by which data is lost or arrives late."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from graphengine.format.stateful import Stateful

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Impairment:
    """The effect of a fault of one sensor or topic.

    Attributes:
        loss: probability that an item is lost; with 1, all items are lost.
        delay: number of ticks by which all other items arrive late.
        ticks: number of ticks after which the fault ends; None: the fault has no end.
        seed: seed of the losses.
    """

    loss: float = 0.0
    delay: int = 0
    ticks: int | None = None
    seed: int = 0


class Faults(Stateful):
    """The faults of sensors or of topics. When a fault ends, the delayed items that have not arrived are lost."""

    kept = ("acting", "_counts", "_ended", "_tick", "_waiting")

    def __init__(self) -> None:
        self._tick, self._ended = 0, False
        self.acting: dict[str, tuple[Impairment, float]] = {}
        """The fault of each sensor or topic, and the number of the last tick in which the fault acts."""
        self._waiting: dict[tuple[str, str], list[tuple[int, Any]]] = {}
        """For each sensor or topic and each receiver: the delayed items, with the number of the tick of arrival."""
        self._counts: Counter[tuple[str, str]] = Counter()
        """For each sensor or topic and each receiver: the number of items since the fault began."""

    def put(self, name: str, fault: Impairment) -> None:
        """Let a fault act on a sensor or topic from the next tick on, instead of the current fault."""
        self.lift(name)
        self.acting[name] = fault, float("inf") if fault.ticks is None else self._tick + fault.ticks

    def lift(self, name: str) -> None:
        """End the fault of a sensor or topic, if there is one."""
        self._ended |= self.acting.pop(name, None) is not None
        for key in [key for key in self._waiting if key[0] == name]:
            del self._counts[key], self._waiting[key]

    def clear(self) -> None:
        """End all faults."""
        for name in [*self.acting]:
            self.lift(name)

    def begin_tick(self) -> bool:
        """Begin a tick and end expired faults; return whether a fault acts, or has ended since the last tick."""
        self._tick += 1
        for name in [name for name, (_, last) in self.acting.items() if self._tick > last]:
            self.lift(name)
        ended, self._ended = self._ended, False
        return ended or bool(self.acting)

    def passing(self, name: str, receiver: str, items: Iterable[T]) -> list[T]:
        """Return the items that reach a receiver in this tick, oldest first.

        Args:
            name: sensor or topic with a fault.
            receiver: name of the receiver; losses are drawn independently for each receiver.
            items: new items.
        """
        fault, key = self.acting[name][0], (name, receiver)
        waiting = self._waiting.setdefault(key, [])
        for item in items:
            self._counts[key] += 1
            if random.Random(f"{fault.seed} {name} {receiver} {self._counts[key]}").random() >= fault.loss:
                waiting.append((self._tick + fault.delay, item))
        arrived: list[T] = [item for tick, item in waiting if tick <= self._tick]
        del waiting[: len(arrived)]
        return arrived
