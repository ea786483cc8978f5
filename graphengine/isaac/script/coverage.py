"""Statement coverage of a script: finds graph-building calls that were skipped because of a condition or an error."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

from graphengine.isaac.script.builders import Function, called
from graphengine.isaac.script.script_source import Position, Script

MARK = "__ran__"
"""Name of the function that an instrumented script calls before each statement, with file, line and column."""
NUMBER = "__number__"
"""Name of a function that an instrumented script applies to each called function; it returns the function to be called."""
FAILED = -1
"""Column that an instrumented script passes to `MARK` after a statement raised an error."""
Ran = Collection[tuple[str, int, int]]
"""Executed statements, as file, line and column."""

_EXITS = (ast.Return, ast.Raise, ast.Continue, ast.Break)
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


def marked(text: str | bytes, path: str, *, forgiving: type[ast.AST] | None = None) -> ast.Module:
    """Return the instrumented syntax tree of a script: statements call `MARK`, and called functions go through `NUMBER`.

    Args:
        text: source code of the script.
        path: file of the script.
        forgiving: class of syntax nodes in whose bodies the script continues after a failed statement; None: no such class.
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
    """Return a statement together with the call of `MARK` that records its execution.

    In the body of a loop, the call has the position of the loop. A module's docstring and its imports from `__future__` get
    no call, because no statement may precede such an import.
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
    """The reason why a call did not run.

    Attributes:
        text: the reason in words, such as `the condition at line 5`; empty if it is unknown.
        condition: line of the condition that excluded the call; 0 without one.
        advice: remedies for the error that prevented the call.
    """

    text: str = ""
    condition: int = 0
    advice: tuple[str, ...] = ()


def _condition(line: int) -> Why:
    return Why(f"the condition at line {line}", line)


class Failure(NamedTuple):
    """An expression of a script through which an error passed: it raised the error, or it called a function that did.

    Attributes:
        path: file of the expression.
        position: position in the file.
        why: the error, in the form of a reason why a call did not run.
        entered: whether the expression is a call whose function began to run.
        handler: line at which the script caught the error; 0 if the error ended the script.
    """

    path: str
    position: Position
    why: Why
    entered: bool
    handler: int

    def keeps(self, call: ast.Call) -> bool:
        """Return whether this error prevented a call: it was raised in the call expression before the function began to run."""
        first, last = (call.lineno, call.col_offset), (call.end_lineno or 0, call.end_col_offset or 0)
        inside = first <= self.position[:2] and self.position[2:] <= last
        return inside and not (self.entered and self.position == (*first, *last))


class Unreached:
    """Finds the graph-building calls of a script that did not run.

    Args:
        script: script or module that was run.
        ran: executed statements.
        names: names of the functions and methods that build graphs.
        failures: errors of the run.
        foreign: names of missing modules; their functions are not regarded as graph-building.
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
        """Return whether a statement was executed."""
        return (self.script.source.path, node.lineno, node.col_offset) in self._ran

    def calls(self) -> Iterator[tuple[ast.Call, Why]]:
        """Yield the graph-building calls that did not run, each with the reason."""
        for call in self._building(self.script.tree):
            yield from ((call, failure.why) for failure in self._failures if failure.keeps(call))
        yield from self._in(self.script.tree.body, Why())

    def _in(self, block: list[ast.stmt], why: Why) -> Iterator[tuple[ast.Call, Why]]:
        """Yield the graph-building calls in a block that did not run, each with the reason.

        `why` is the reason if the first statement of the block did not run.
        """
        before: ast.stmt | None = None
        failed: Why | None = None
        for statement in block:
            if isinstance(statement, Function | ast.ClassDef):
                yield from self._in(statement.body, Why())
            elif self.ran(statement):
                before = statement
                skipped = failed or self._asking(statement)
                if skipped:  # a call did not run in at least one turn of a loop
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
        """Return why execution did not continue after a statement: a condition in it, an error in it, or an unknown reason."""
        exits = _EXITS[:2] if isinstance(statement, ast.For | ast.AsyncFor | ast.While) else _EXITS
        for node in ast.walk(statement):
            if isinstance(node, ast.If) and any(self._leaves(part, exits) for part in ast.walk(node)):
                return _condition(node.lineno)
        for failure in self._inside(statement):
            return failure.why
        left = any(self._leaves(part, exits) for part in ast.walk(statement))
        return Why() if left else Why(f"an error at line {statement.lineno}")

    def _inside(self, statement: ast.stmt) -> list[Failure]:
        """Return the errors that passed through the lines of a statement."""
        return [failure for failure in self._failures if holds(statement, failure.position[0])]

    def _asking(self, statement: ast.stmt) -> Why | None:
        """Return the caught error in the condition of an `if` statement; None if there is no such error."""
        first = statement.body[0] if isinstance(statement, ast.If) else statement
        start = first.lineno, first.col_offset
        return next((f.why for f in self._inside(statement) if f.handler and f.position[:2] < start), None)

    def _leaves(self, node: ast.AST, exits: tuple[type[ast.stmt], ...]) -> bool:
        """Return whether a syntax node is an executed statement that leaves its block, such as `return` or `exit()`."""
        ends = isinstance(node, ast.Expr) and called(node.value) in ("exit", "quit")
        return isinstance(node, ast.stmt) and (ends or isinstance(node, exits)) and self.ran(node)

    def _building(self, tree: ast.AST) -> Iterator[ast.Call]:
        """Yield the graph-building calls in a syntax tree."""
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and called(node, self._foreign) in self._names:
                yield node


def holds(statement: ast.stmt, line: int) -> bool:
    """Return whether a line is within a statement."""
    return statement.lineno <= line <= (statement.end_lineno or 0)


def asking(tree: ast.Module, line: int) -> list[int]:
    """Return the lines on which the condition at a line depends: its own lines, and those that define names in it."""
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    asked = next((node for node in nodes if node.lineno == line and _asks(node)), None)
    parts: list[ast.AST] = [getattr(asked, name) for name in ("test", "iter", "subject") if hasattr(asked, name)]
    lines = [line]
    for part in parts:  # grows while the loop runs
        lines += range(part.lineno, (part.end_lineno or 0) + 1)  # type: ignore[attr-defined]
        names = {getattr(inner, "id", getattr(inner, "attr", "")) for inner in ast.walk(part)} - {""}
        made = [node for node in nodes if node not in parts and _makes(node) & names]
        parts += [node for node in made if isinstance(node, Function)]
        parts += [node for node in made if node.lineno < line and not isinstance(node, Function)][-1:]
    return lines


def _makes(statement: ast.stmt) -> set[str]:
    """Return the names that an assignment or loop binds, or the name of a defined function."""
    if isinstance(statement, Function):
        return {statement.name}
    targets = getattr(statement, "targets", [getattr(statement, "target", None)])
    return {getattr(target, "id", getattr(target, "attr", "")) for target in targets if target}


def _asks(statement: ast.stmt) -> bool:
    """Return whether a statement runs its body only under a condition; `if __name__ == …` does not count."""
    if isinstance(statement, ast.If):
        return "__name__" not in ast.unparse(statement.test)
    return isinstance(statement, ast.For | ast.AsyncFor | ast.While | ast.Match)


def _inner(statement: ast.stmt, name: str) -> Iterator[list[ast.stmt]]:
    """Yield the blocks in the field `name` of a statement. The `else` block of a `try` is yielded as the end of its body."""
    part = getattr(statement, name, None)
    if isinstance(statement, ast.Try) and name in ("body", "orelse"):
        yield from [statement.body + statement.orelse] * (name == "body")
    elif name in ("handlers", "cases"):
        yield from (one.body for one in part or ())
    elif part:
        yield part
