"""Places in scripts: of the call that is made, and of a text in it such as the name of a node."""

from __future__ import annotations

import ast

from graphengine.diagnostics import Source, Span


class Script:
    """A script that was parsed.

    Raises:
        SyntaxError: it is no Python.
        ValueError: it holds what no Python source holds.
        RecursionError: it is nested too deep.
    """

    def __init__(self, path: str, text: str) -> None:
        self.source = Source(path, tuple(text.split("\n")))
        self.tree = ast.parse(text, path)
        self.texts: dict[str, list[ast.Constant]] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                self.texts.setdefault(node.value, []).append(node)

    def span(self, line: int, end_line: int | None, column: int, text: str = "") -> Span:
        """The place of a text in a call that reaches from line to line; the call's beginning where it does not stand there."""
        for node in self.texts.get(text, ()):
            if line <= node.lineno <= (end_line or line):
                return Span(self.source, node.lineno, self._column(node.lineno, node.col_offset) + 1, len(text) + 2)
        return Span(self.source, line, self._column(line, column) + 1)

    def functions_that_call(self, name: str) -> list[str]:
        """Names of the functions, and of the classes with methods, that call something of a name, with their lines."""
        return [
            f"{part.name} (line {part.lineno})"
            for part in self.tree.body
            if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
            and any(isinstance(node, ast.Attribute) and node.attr == name for node in ast.walk(part))
        ]

    def _column(self, line: int, offset: int) -> int:
        """Characters before a place that Python counts in bytes."""
        text = self.source.lines[line - 1] if line <= len(self.source.lines) else ""
        return len(text.encode()[:offset].decode("utf-8", "ignore"))
