"""Counts the problems of each node of a session: errors, warnings and dropped values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from graphengine.node.dropped_values import DroppedValues
from graphengine.runtime.log_lines import LogLines

MOST_NODES, LONGEST_TEXT = 1000, 2000
"""Maximum number of nodes whose problems are kept, and maximum length of a kept text, characters."""


class NodeProblems:
    """Counts the problems of each node, and keeps the text of the last problem; prim paths identify the nodes.

    Attributes:
        dropped: counts of dropped values; None if no values are dropped, because a bad value ends the run.
    """

    def __init__(self, dropped: DroppedValues | None = None) -> None:
        self.dropped = dropped
        self._graphs: tuple[str, ...] | None = None
        """Prim paths of the existing graphs, each with a slash appended; None before the first call of `keep`."""
        self._counts: dict[str, int] = {}
        """Number of problems of each node without dropped values, by the node's prim path."""
        self._texts: dict[str, str] = {}
        self.lines = LogLines()
        """The newest log messages, those of no node too."""
        self.logged: Counter[str] = Counter()
        """Number of messages of each severity, including messages without a node."""
        self._errors: set[str] = set()

    def begin(self, dropped: DroppedValues | None, time: Callable[[], float]) -> None:
        """Count the dropped values of a session, and log with its simulation time, s."""
        self.dropped, self.lines.time = dropped, time

    def log(self, severity: str, node: str, text: str) -> None:
        """Count an error or warning that a node logs; for a dropped value, which `dropped` counts, only keep the text."""
        self.logged[severity] += 1
        self.lines.add(severity, node, text)
        if not node or severity not in ("error", "warning"):
            return
        if severity == "warning" and node in self._drops():
            self._note(node, text)
        else:
            self._count(node, text, severity)

    def add(self, node: str, text: str) -> None:
        """Count an error of a node that is not in its log."""
        self.lines.add("error", node, text)
        self._count(node, text, "error")

    def _count(self, node: str, text: str, severity: str) -> None:
        self._note(node, text)
        if node in self._texts:
            self._counts[node] = self._counts.get(node, 0) + 1
            if severity == "error":
                self._errors.add(node)

    def _note(self, node: str, text: str) -> None:
        if node and (node in self._texts or len(self._texts) < MOST_NODES):
            self._texts[node] = text[:LONGEST_TEXT]

    def _drops(self) -> Mapping[str, int]:
        return self.dropped.ticks if self.dropped is not None else {}

    def keep(self, graphs: Sequence[str]) -> None:
        """Remove the problems of nodes in removed graphs; `graphs` has the prim paths of the existing graphs."""
        self._graphs = tuple(f"{graph}/" for graph in graphs)
        for node in [node for node in self._texts if not node.startswith(self._graphs)]:
            del self._texts[node]
            self._counts.pop(node, None)
            self._errors.discard(node)

    def all(self) -> Mapping[str, Any]:
        """Return severity, number and last text of the problems of each node as JSON values, by the node's prim path."""
        drops = self._drops()
        others = [node for node in drops if node not in self._texts and node.startswith(self._graphs or "")]
        return {
            node: {
                "severity": "error" if node in self._errors else "warning",
                "count": self._counts.get(node, 0) + drops.get(node, 0),
                "text": self._texts.get(node, "the node dropped values that it cannot use"),
            }
            for node in (*self._texts, *others[:MOST_NODES])
        }
