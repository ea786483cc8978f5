"""Finds out which flags of a region imply each other: a branch runs only if the branches before it have fired it."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from functools import reduce


class GuardTree:
    """A tree of the flags of a region: a flag is set only if its parent is set. The root is "", which is always set.

    `number` assigns each flag an interval of positions, which contains the intervals of the flags below. A set of flags is a
    sorted list of the starts of their intervals, in which no flag lies below another.
    """

    def __init__(self) -> None:
        self._parent = {"": ""}
        self._jump = {"": ""}
        """For each flag: an ancestor far above it. Searches jump to this ancestor where they can, and take O(log n) steps."""
        self._depth = {"": 0}
        self._end: dict[int, int] = {}
        """For the start of each interval: its end."""
        self._start: dict[str, int] = {}

    def add(self, flag: str, causes: Iterable[str]) -> str:
        """Add a flag that is set only if one of `causes` is set, unless the tree has the flag; return the flag."""
        if flag not in self._parent:
            parent = reduce(self._common, causes)
            far, depth = self._jump[parent], self._depth
            even = depth[parent] - depth[far] == depth[far] - depth[self._jump[far]]
            self._parent[flag], self._jump[flag] = parent, self._jump[far] if even else parent
            depth[flag] = depth[parent] + 1
        return flag

    def _common(self, one: str, other: str) -> str:
        """Return the deepest flag that both flags imply."""
        depth, jump = self._depth, self._jump
        while one != other:
            if depth[one] < depth[other]:
                one, other = other, one
            if depth[one] > depth[other]:
                one = jump[one] if depth[jump[one]] >= depth[other] else self._parent[one]
            elif jump[one] != jump[other]:
                one, other = jump[one], jump[other]
            else:
                one, other = self._parent[one], self._parent[other]
        return one

    def number(self) -> None:
        """Number all flags, after the last one was added."""
        size = dict.fromkeys(self._parent, 1)
        flags = list(self._parent)[1:]
        for flag in reversed(flags):  # each flag comes after its parent
            size[self._parent[flag]] += size[flag]
        free, self._start, self._end = {"": 1}, {"": 0}, {0: size[""]}
        for flag in flags:
            start = free[self._parent[flag]]
            self._start[flag], self._end[start] = start, start + size[flag]
            free[self._parent[flag]], free[flag] = start + size[flag], start + 1

    def implies(self, flag: str, flags: list[int]) -> bool:
        """Return whether a flag implies one of a set of flags."""
        start = self._start[flag]
        before = bisect_right(flags, start)
        return before > 0 and start < self._end[flags[before - 1]]

    def include(self, flag: str, flags: list[int]) -> None:
        """Add a flag to a set, and remove the flags that imply the new flag. The new flag must imply no flag of the set."""
        start = self._start[flag]
        flags[bisect_left(flags, start) : bisect_left(flags, self._end[start])] = [start]
