"""Counts the problems of each node of a session: errors, warnings and dropped values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphengine.node.dropped_values import DroppedValues

MOST_NODES, LONGEST_TEXT = 1000, 2000
"""Maximum number of nodes with problems, and of characters of a text, to keep."""


class NodeProblems:
    """Problems of nodes by prim path: number of problems and text of the last one.

    Args:
        dropped: counts of dropped values; None if a bad value ends the run.
    """

    def __init__(self, dropped: DroppedValues | None) -> None:
        self._dropped = dropped
        self._counts: dict[str, int] = {}
        """Number of problems other than dropped values, by prim path."""
        self._texts: dict[str, str] = {}
        self._errors: set[str] = set()
        self._shown: Mapping[str, Any] | None = None

    def log(self, severity: str, node: str, text: str) -> None:
        """Count a log message of a node as a problem; warnings about dropped values are counted in `dropped`."""
        if not node or severity not in ("error", "warning"):
            return
        if severity == "warning" and node in self._drops():
            self._note(node, text)
        else:
            self.add(node, text, severity)

    def add(self, node: str, text: str, severity: str = "error") -> None:
        """Count a problem of a node."""
        self._note(node, text)
        if node in self._texts:
            self._counts[node] = self._counts.get(node, 0) + 1
            if severity == "error":
                self._errors.add(node)

    def _note(self, node: str, text: str) -> None:
        if node and (node in self._texts or len(self._texts) < MOST_NODES):
            self._texts[node] = text[:LONGEST_TEXT]

    def _drops(self) -> Mapping[str, int]:
        return self._dropped.ticks if self._dropped is not None else {}

    def news(self) -> Mapping[str, Any] | None:
        """Return severity, count and last text by prim path, as JSON values; None if nothing changed since the last call."""
        drops = self._drops()
        nodes = [*self._texts, *[node for node in drops if node not in self._texts][:MOST_NODES]]
        found = {
            node: {
                "severity": "error" if node in self._errors else "warning",
                "count": self._counts.get(node, 0) + drops.get(node, 0),
                "text": self._texts.get(node, "the node dropped values that it cannot use"),
            }
            for node in nodes
        }
        if found == self._shown:
            return None
        self._shown = found
        return found
