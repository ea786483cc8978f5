"""Evaluates scripts that consist of literals, names and calls of `og` without running them as Python code.

The evaluation calls only stubs and no Python functions except `float`; a script that does anything else must be run.
"""

from __future__ import annotations

import ast
from types import ModuleType
from typing import Any

from graphengine.format.diagnostics import Span
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.modules import ROOTS, make_modules
from graphengine.isaac.omniverse.stubs import StubModule, StubObject
from graphengine.isaac.script.builders import BUILDING, called
from graphengine.isaac.script.script_source import Script
from graphengine.sandbox.expressions import Guard, compiled, cost, syntax

_SYNTAX = syntax(
    "Expression Constant Name Load JoinedStr FormattedValue List Tuple Dict UnaryOp USub BinOp Add Attribute Call keyword"
)
_OURS = f"{StubObject.__module__.rpartition('.')[0]}."


class NotStaticError(Exception):
    """A script contains more than literals, names and calls of `og`, so that it must be run."""


def evaluate(script: Script) -> GraphRecorder | None:
    """Return a recorder with the graphs that a script builds; None if the script must be run as Python code."""
    evaluator = _Evaluator(script)
    try:
        evaluator.block(script.tree.body)
    except Exception:  # the script is then run, which reports each failure with its position
        return None
    return evaluator.recorder


class _Evaluator(Guard):
    def __init__(self, script: Script) -> None:
        super().__init__()
        self.script = script
        self.recorder = GraphRecorder(self._where)
        self.modules = make_modules(self.recorder)
        self.names: dict[str, Any] = {"__name__": "__main__", "__file__": script.source.path, "float": float}
        self.place = 1, 1, 0
        """First line, last line and column of the current expression or call."""

    def _where(self, text: str) -> Span | None:
        return self.script.span(*self.place, text)

    def block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            method = getattr(self, f"_{type(statement).__name__}", None)
            if method is None:
                raise NotStaticError
            method(statement)

    def _Expr(self, statement: ast.Expr) -> None:
        self.value(statement.value)

    def _Pass(self, statement: ast.Pass) -> None:
        pass

    def _Import(self, statement: ast.Import) -> None:
        for alias in statement.names:
            module = self._module(alias.name)
            first = alias.name.partition(".")[0]
            self.names[alias.asname or first] = module if alias.asname else self._module(first)

    def _ImportFrom(self, statement: ast.ImportFrom) -> None:
        if statement.level or not statement.module:
            raise NotStaticError
        for alias in statement.names:
            if alias.name == "*":
                raise NotStaticError
            self.names[alias.asname or alias.name] = getattr(self._module(statement.module), alias.name)

    def _module(self, name: str) -> ModuleType:
        if name.partition(".")[0] not in ROOTS:
            raise NotStaticError
        if name not in self.modules:
            self.modules[name] = StubModule(name, self.recorder, self.modules)
        return self.modules[name]

    def _Assign(self, statement: ast.Assign) -> None:
        value = self.value(statement.value)
        for target in statement.targets:
            if isinstance(target, ast.Tuple) and isinstance(value, tuple) and len(target.elts) == len(value):
                for one, part in zip(target.elts, value, strict=True):
                    self._bind(one, part)
            else:
                self._bind(target, value)

    def _AnnAssign(self, statement: ast.AnnAssign) -> None:
        if statement.value is not None:
            self._bind(statement.target, self.value(statement.value))

    def _bind(self, target: ast.expr, value: Any) -> None:
        if not isinstance(target, ast.Name):
            raise NotStaticError
        self.names[target.id] = value

    def _If(self, statement: ast.If) -> None:
        branches = statement.body, statement.orelse
        taken, other = branches if self.value(statement.test) else branches[::-1]
        if any(called(node) in BUILDING for part in other for node in ast.walk(part)):
            raise NotStaticError  # the script is then run, which reports calls that are not reached
        self.block(taken)

    def value(self, node: ast.expr) -> Any:
        """Return the value of an expression.

        Raises:
            NotStaticError: the expression is a comparison other than `==` of two strings, or accesses something else than stubs.
            ForbiddenError: the expression contains other syntax, or exceeds the limits.
        """
        if isinstance(node, ast.Compare):
            left, right = (self.value(side) for side in (node.left, *node.comparators))
            if not isinstance(node.ops[0], ast.Eq) or not isinstance(left, str) or not isinstance(right, str):
                raise NotStaticError
            return left == right
        self.place = node.lineno, node.end_lineno or node.lineno, node.col_offset
        return self.evaluate(compiled(node, _SYNTAX, self.names), self.names)

    def attribute(self, value: Any, name: str) -> Any:
        if name.startswith("_") or not _ours(value):
            raise NotStaticError
        return getattr(value, name)

    def call(self, place: tuple[int, int, int], function: Any, /, *arguments: Any, **named: Any) -> Any:
        if function is not float and not _ours(function):
            raise NotStaticError
        before, self.place = self.place, place
        result = super().call(place, function, *arguments, **named)
        self.place = before
        return result

    def operate(self, name: str, /, *operands: Any) -> Any:
        if len(set(map(type, operands))) > 1 or not isinstance(operands[0], str | int | float | list):
            raise NotStaticError
        return super().operate(name, *operands)

    def weigh(self, *values: Any) -> None:
        for value in values:
            self.spend(cost(value))

    def format(self, value: Any, conversion: int, form: str) -> str:
        if not isinstance(value, str | int | float) or conversion != -1 or form:
            raise NotStaticError
        return str(value)


def _ours(thing: Any) -> bool:
    """Return whether an object is a stub, a class of stubs, or a method or instance of such a class."""
    if isinstance(thing, StubModule | StubObject):
        return True
    function = getattr(thing, "func", thing)  # `func` of the partial object that is a method of a controller
    made_by = function.__module__ if callable(function) and not isinstance(thing, type) else None
    owner = thing if isinstance(thing, type) else type(thing)
    return (made_by or "").startswith(_OURS) or owner.__module__.startswith(_OURS) or owner.__name__ == "Controller"
