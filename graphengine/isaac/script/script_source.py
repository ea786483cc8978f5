"""Parsed scripts, with the spans of calls and of texts such as node names."""

from __future__ import annotations

import ast

from graphengine.format.diagnostics import Source, Span

_COUNTING = frozenset(("range", "count", "repeat"))
"""Functions whose numbers loops count."""


class Script:
    """A parsed script.

    Raises:
        SyntaxError: it is no Python.
        ValueError: it holds what no Python source holds.
        RecursionError: it is nested too deep.
    """

    def __init__(self, path: str, text: str) -> None:
        self.source = Source(path, tuple(text.split("\n")))
        self.tree = ast.parse(text, path)
        self.texts: dict[str, list[ast.Constant]] = {}
        self.loops: list[tuple[int, int]] = []
        """First and last lines of the loops that do not go over things, as those over frames do not; outer ones first."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.While | ast.For) and (isinstance(node, ast.While) or _counts(node.iter)):
                self.loops.append((node.lineno, node.end_lineno or node.lineno))
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value:
                self.texts.setdefault(node.value, []).append(node)

    def span(self, line: int, end_line: int | None, column: int, text: str = "") -> Span:
        """The span of a text within the lines of a call, else of the call's beginning."""
        for node in self.texts.get(text, ()):
            if line <= node.lineno <= (end_line or line):
                return Span(self.source, node.lineno, self._column(node.lineno, node.col_offset) + 1, len(text) + 2)
        return Span(self.source, line, self._column(line, column) + 1)

    def _column(self, line: int, offset: int) -> int:
        """Convert Python's byte offset to characters."""
        text = self.source.lines[line - 1] if line <= len(self.source.lines) else ""
        return offset if text.isascii() else len(text[:offset].encode()[:offset].decode("utf-8", "ignore"))


def _counts(node: ast.expr) -> bool:
    """Whether a loop's expression is a counter such as `range(100)`."""
    return any(getattr(part, "id", getattr(part, "attr", "")) in _COUNTING for part in ast.walk(node))
