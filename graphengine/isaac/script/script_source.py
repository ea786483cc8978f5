"""Parsed scripts: spans of calls and strings in them, and the position of the call that is running."""

from __future__ import annotations

import ast
import contextlib
import functools
import importlib.util
import itertools
import os
import sys
import types
from collections.abc import Iterator, Sequence
from pathlib import Path

from graphengine.format.diagnostics import Source, Span
from graphengine.isaac.omniverse.frames import Call, Loop

Position = tuple[int, int, int, int]
"""Position of an expression: first line and column, last line and column; columns are byte offsets from 0."""

_COUNTING = frozenset(("range", "count", "repeat"))
"""Names of functions that count the turns of a loop, such as `range`."""


class Script:
    """A parsed script or module.

    Raises:
        SyntaxError: the text is not valid Python.
        ValueError: the text contains characters that are illegal in Python source.
        RecursionError: the code is nested too deeply.
    """

    def __init__(self, path: str, text: str) -> None:
        self.source = Source(path, tuple(text.split("\n")))
        self.tree = ast.parse(text, path)
        self.texts: dict[str, list[ast.Constant]] = {}
        self.loops: list[tuple[int, int]] = []
        """First and last line of each `while` loop and counting `for` loop, which may render frames; outer loops first."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.While | ast.For) and (isinstance(node, ast.While) or _counts(node.iter)):
                self.loops.append((node.lineno, node.end_lineno or node.lineno))
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value:
                self.texts.setdefault(node.value, []).append(node)

    def span(self, line: int, end_line: int | None, column: int, text: str = "") -> Span:
        """Return the span of the string literal `text` in a call, or the start of the call if it lacks this literal."""
        for node in self.texts.get(text, ()):
            if line <= node.lineno <= (end_line or line):
                return Span(self.source, node.lineno, self._column(node.lineno, node.col_offset) + 1, len(text) + 2)
        return Span(self.source, line, self._column(line, column) + 1)

    def _column(self, line: int, offset: int) -> int:
        """Return the column in characters, from 0, for a byte offset from a syntax tree."""
        text = self.source.lines[line - 1] if line <= len(self.source.lines) else ""
        return offset if text.isascii() else len(text[:offset].encode()[:offset].decode("utf-8", "ignore"))


class Scripts:
    """A script and the modules in readable folders that run with it.

    Args:
        folders: folders that may be read.
    """

    main: Script
    """The script itself. `load` sets it after the process is confined."""

    def __init__(self, folders: Sequence[str]) -> None:
        self.folders = folders
        self._known: dict[str, Script | None] = {}

    def load(self, path: str, text: str) -> None:
        """Parse the script itself and store it as `main`; raise the same errors as `Script`."""
        self.main = self._known[path] = Script(path, text)

    def __iter__(self) -> Iterator[Script]:
        return filter(None, self._known.values())

    def at(self, path: str) -> Script | None:
        """Return the parsed script or module at a path; None if it is outside the readable folders or cannot be parsed."""
        if path not in self._known:
            self._known[path] = None
            if path.startswith(tuple(folder + os.sep for folder in self.folders)) and path.endswith(".py"):
                with contextlib.suppress(OSError, SyntaxError, ValueError, RecursionError):
                    self._known[path] = Script(path, importlib.util.decode_source(Path(path).read_bytes()))
        return self._known[path]

    def where(self, text: str) -> Span | None:
        """Return the span of the script's current call, or of the string literal `text` in it; None if no script is running."""
        for script, frame in self._frames():
            line, column, end, _ = _position(frame.f_code, frame.f_lasti, frame.f_lineno)
            return script.span(line, end, column, text)
        return None

    def stack(self) -> tuple[Call, list[Loop]]:
        """Return the script's current call and the loops around this call, innermost first."""
        call, loops = ("", 0, 0), list[Loop]()
        for script, frame in self._frames():
            call = call if call[0] else (script.source.path, frame.f_code.co_firstlineno, frame.f_lasti)
            inside = [first for first, last in script.loops if first <= frame.f_lineno <= last]
            loops += ((script.source.path, first) for first in reversed(inside))
            if not any(known.loops for known in self):
                break
        return call, loops

    def place(self, error: BaseException) -> Span | None:
        """Return the span of the innermost expression of the script in an error's traceback; None if the script is not in it."""
        place = None
        for script, (line, column, end, _) in self.trace(error):
            place = script.span(line, end, column)
        return place

    def trace(self, error: BaseException) -> Iterator[tuple[Script, Position]]:
        """Yield the entries of an error's traceback that are in the script or its modules, outermost first."""
        trace = error.__traceback__
        while trace is not None:
            if script := self.at(trace.tb_frame.f_code.co_filename):
                yield script, _position(trace.tb_frame.f_code, trace.tb_lasti, trace.tb_lineno)
            trace = trace.tb_next

    def _frames(self) -> Iterator[tuple[Script, types.FrameType]]:
        """Yield the scripts and frames on the current call stack, innermost first."""
        frame: types.FrameType | None = sys._getframe(1)
        while frame is not None:
            if script := self.at(frame.f_code.co_filename):
                yield script, frame
            frame = frame.f_back


def _counts(node: ast.expr) -> bool:
    """Return whether the iterable of a `for` loop calls a counting function, as in `range(100)`."""
    return any(getattr(part, "id", getattr(part, "attr", "")) in _COUNTING for part in ast.walk(node))


@functools.lru_cache(maxsize=1000)  # loops query the same positions again
def _position(code: types.CodeType, instruction: int, near: int) -> Position:
    """Return the position of a bytecode instruction at a byte offset; line `near` if the code object has no positions."""
    found = next(itertools.islice(code.co_positions(), instruction // 2, None), (near, near, 0, 0))
    line, end, column, last = (number or 0 for number in found)
    return line or near, column, end or near, last
