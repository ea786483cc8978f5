"""Statement coverage of a script: finds graph-building calls that were skipped because of a condition or an error."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

from graphengine.isaac.script.builders import Function, called
from graphengine.isaac.script.script_source import Position, Script

MARK = "__ran__"
"""Function that each statement calls before it runs, with the file, the line and the column."""
NUMBER = "__number__"
"""Function that gives a script what it calls in the place of a function that it would call."""
FAILED = -1
"""The column of the mark of a statement that failed."""
Ran = Collection[tuple[str, int, int]]
"""Of the statements that ran: file, line, column."""

_EXITS = (ast.Return, ast.Raise, ast.Continue, ast.Break)
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


def marked(text: str | bytes, path: str, *, forgiving: type[ast.AST] | None = None) -> ast.Module:
    """Return a script whose statements record that they run, and whose numeric functions accept stubs.

    Args:
        text: source code of the script.
        path: file of the script.
        forgiving: module, or any, in which the script continues after a statement that fails.
    """
    tree = ast.parse(text, path)
    nodes = list(ast.walk(tree))
    tried = {id(part) for node in nodes if isinstance(node, ast.Try) for block in node.body for part in ast.walk(block)}
    for node in nodes:
        if isinstance(node, ast.Call) and (node.args or node.keywords):
            chosen = ast.Call(ast.Name(NUMBER, ast.Load()), [node.func], [])
            ast.fix_missing_locations(ast.copy_location(chosen, node.func))
            node.func = chosen
        forgives = forgiving is not None and isinstance(node, forgiving) and id(node) not in tried
        for name in _BLOCKS[:3]:
            block = getattr(node, name, None)
            if isinstance(block, list):
                goes_on = forgives and not (isinstance(node, ast.Try) and name == "body")
                parts = [part for statement in block for part in _with_mark(node, statement, path, goes_on)]
                setattr(node, name, parts)
    return tree


def _with_mark(owner: ast.AST, statement: ast.stmt, path: str, forgiving: bool) -> tuple[ast.stmt, ...]:
    """Return a statement after its mark, whose place is that of the loop around it: there the time limit is checked.

    The docstring and future imports of a module have no marks, because no statement may precede such an import.
    """
    mark = _mark(path, statement.lineno, statement.col_offset)
    loops = isinstance(owner, ast.For | ast.AsyncFor | ast.While)
    ast.fix_missing_locations(ast.copy_location(mark, owner if loops else statement))
    first = isinstance(statement, ast.ImportFrom) and statement.module == "__future__"
    first = first or (isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant))  # a docstring
    if first and isinstance(owner, ast.Module):
        return (statement,)
    if forgiving:
        failed = _mark(path, statement.lineno, FAILED)
        handler = ast.ExceptHandler(ast.parse("Exception, SystemExit", mode="eval").body, None, [failed])
        attempt = ast.Try([statement], [handler], [], [])
        return mark, ast.fix_missing_locations(ast.copy_location(attempt, statement))
    return (statement, mark) if first else (mark, statement)


def _mark(*place: str | int) -> ast.Expr:
    return ast.Expr(ast.Call(ast.Name(MARK, ast.Load()), [ast.Constant(part) for part in place], []))


class Why(NamedTuple):
    """The reason why a call is skipped: a text, the line of its condition if any, and a remedy for an error."""

    text: str = ""
    condition: int = 0
    advice: tuple[str, ...] = ()


def _condition(line: int) -> Why:
    return Why(f"the condition at line {line}", line)


class Failure(NamedTuple):
    """An expression of a script that raised an error.

    Attributes:
        path: file of the expression.
        position: position in the file.
        why: reason with the error.
        entered: whether the expression is a call that was started.
        handler: line at which the script caught the error; 0 if it ended the script.
    """

    path: str
    position: Position
    why: Why
    entered: bool
    handler: int

    def keeps(self, call: ast.Call) -> bool:
        """Return whether the error skipped a call that contains the expression."""
        first, last = (call.lineno, call.col_offset), (call.end_lineno or 0, call.end_col_offset or 0)
        inside = first <= self.position[:2] and self.position[2:] <= last
        return inside and not (self.entered and self.position == (*first, *last))


class Unreached:
    """Finds the graph-building calls of a script that were skipped.

    Args:
        script: script that was run.
        ran: statements that ran.
        names: functions and methods that build graphs.
        failures: errors of the run.
        foreign: missing modules, which do not build graphs.
    """

    def __init__(
        self,
        script: Script,
        ran: Ran,
        names: Collection[str] = (),
        failures: Iterable[Failure] = (),
        foreign: Collection[str] = (),
    ) -> None:
        self.script, self._ran, self._names, self._foreign = script, ran, names, foreign
        self._failures = [failure for failure in failures if failure.path == script.source.path]

    def ran(self, node: ast.stmt) -> bool:
        """Return whether a statement ran."""
        return (self.script.source.path, node.lineno, node.col_offset) in self._ran

    def calls(self) -> Iterator[tuple[ast.Call, Why]]:
        """Yield the skipped calls with the reasons."""
        for call in self._building(self.script.tree):
            yield from ((call, failure.why) for failure in self._failures if failure.keeps(call))
        yield from self._in(self.script.tree.body, Why())

    def _in(self, block: list[ast.stmt], why: Why) -> Iterator[tuple[ast.Call, Why]]:
        """Yield the calls in a block that is skipped."""
        before: ast.stmt | None = None
        failed: Why | None = None
        for statement in block:
            if isinstance(statement, Function | ast.ClassDef):
                yield from self._in(statement.body, Why())
            elif self.ran(statement):
                before = statement
                skipped = failed or self._asking(statement)
                if skipped:  # at least in one turn of a loop
                    yield from ((call, skipped) for call in self._building(statement))
                left = (f.why for f in self._inside(statement) if f.handler and not holds(statement, f.handler))
                failed = next(left, failed)
                for name in () if skipped else _BLOCKS:
                    for inner in _inner(statement, name):
                        asks = name in ("body", "orelse", "cases") and _asks(statement) and not self.ran(inner[0])
                        yield from self._in(inner, _condition(statement.lineno) if asks else Why())
            else:
                if before is not None:
                    why, before = self._left(before), None
                if why.text:
                    yield from ((call, why) for call in self._building(statement))

    def _left(self, statement: ast.stmt) -> Why:
        """Return the reason why the statement after one that ran did not run."""
        exits = _EXITS[:2] if isinstance(statement, ast.For | ast.AsyncFor | ast.While) else _EXITS
        for node in ast.walk(statement):
            if isinstance(node, ast.If) and any(self._leaves(part, exits) for part in ast.walk(node)):
                return _condition(node.lineno)
        for failure in self._inside(statement):
            return failure.why
        left = any(self._leaves(part, exits) for part in ast.walk(statement))
        return Why() if left else Why(f"an error at line {statement.lineno}")

    def _inside(self, statement: ast.stmt) -> list[Failure]:
        """Return the errors within a statement."""
        return [failure for failure in self._failures if holds(statement, failure.position[0])]

    def _asking(self, statement: ast.stmt) -> Why | None:
        """Return the error that the script caught in a statement's condition, if any."""
        first = statement.body[0] if isinstance(statement, ast.If) else statement
        start = first.lineno, first.col_offset
        return next((f.why for f in self._inside(statement) if f.handler and f.position[:2] < start), None)

    def _leaves(self, node: ast.AST, exits: tuple[type[ast.stmt], ...]) -> bool:
        """Return whether a statement left its block."""
        ends = isinstance(node, ast.Expr) and called(node.value) in ("exit", "quit")
        return isinstance(node, ast.stmt) and (ends or isinstance(node, exits)) and self.ran(node)

    def _building(self, tree: ast.AST) -> Iterator[ast.Call]:
        """Yield graph-building calls."""
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and called(node, self._foreign) in self._names:
                yield node


def holds(statement: ast.stmt, line: int) -> bool:
    """Return whether a line is in a statement."""
    return statement.lineno <= line <= (statement.end_lineno or 0)


def asking(tree: ast.Module, line: int) -> list[int]:
    """Return the lines that determine the condition at a line: its own, and the assignments of its names."""
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    asked = next((node for node in nodes if node.lineno == line and _asks(node)), None)
    parts: list[ast.AST] = [getattr(asked, name) for name in ("test", "iter", "subject") if hasattr(asked, name)]
    lines = [line]
    for part in parts:  # grows
        lines += range(part.lineno, (part.end_lineno or 0) + 1)  # type: ignore[attr-defined]
        names = {getattr(inner, "id", getattr(inner, "attr", "")) for inner in ast.walk(part)} - {""}
        made = [node for node in nodes if node not in parts and _makes(node) & names]
        parts += [node for node in made if isinstance(node, Function)]
        parts += [node for node in made if node.lineno < line and not isinstance(node, Function)][-1:]
    return lines


def _makes(statement: ast.stmt) -> set[str]:
    """Return the names that a statement assigns."""
    if isinstance(statement, Function):
        return {statement.name}
    targets = getattr(statement, "targets", [getattr(statement, "target", None)])
    return {getattr(target, "id", getattr(target, "attr", "")) for target in targets if target}


def _asks(statement: ast.stmt) -> bool:
    """Return whether a statement has a condition, which may be that a loop has items."""
    if isinstance(statement, ast.If):
        return "__name__" not in ast.unparse(statement.test)
    return isinstance(statement, ast.For | ast.AsyncFor | ast.While | ast.Match)


def _inner(statement: ast.stmt, name: str) -> Iterator[list[ast.stmt]]:
    """Return blocks of a statement; the `else` of a `try` follows its body."""
    part = getattr(statement, name, None)
    if isinstance(statement, ast.Try) and name in ("body", "orelse"):
        yield from [statement.body + statement.orelse] * (name == "body")
    elif name in ("handlers", "cases"):
        yield from (one.body for one in part or ())
    elif part:
        yield part
