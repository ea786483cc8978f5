"""Scripts of literals, names and calls of `og`, evaluated without being run: most that a person wrote for one graph are.

What is called are the stand-ins only, never anything of Python's; whatever else a script does makes it one to be run.
"""

from __future__ import annotations

import ast
from types import ModuleType, UnionType
from typing import Any

from graphengine.format.diagnostics import Span
from graphengine.isaac.omniverse.modules import ROOTS, make_modules
from graphengine.isaac.omniverse.recorder import Recorder
from graphengine.isaac.omniverse.stand_in import StandIn, StandInModule
from graphengine.isaac.script.builders import BUILDING, called
from graphengine.isaac.script.places import Script

_OURS = f"{StandIn.__module__.rpartition('.')[0]}."


class NotPlainError(Exception):
    """The script does more than can be evaluated here."""


def evaluate(script: Script) -> Recorder | None:
    """What a script builds; None if it has to be run to know."""
    evaluator = _Evaluator(script)
    try:
        evaluator.block(script.tree.body)
    except Exception:  # it is run then, where each failure is told with its place
        return None
    return evaluator.recorder


class _Evaluator:
    def __init__(self, script: Script) -> None:
        self.script = script
        self.recorder = Recorder(self._where)
        self.modules = make_modules(self.recorder)
        self.names: dict[str, Any] = {"__name__": "__main__", "__file__": script.source.path, "float": float}
        self.call: ast.Call | None = None

    def _where(self, text: str) -> Span | None:
        call = self.call
        return self.script.span(call.lineno, call.end_lineno, call.col_offset, text) if call else None

    def block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            method = getattr(self, f"_{type(statement).__name__}", None)
            if method is None:
                raise NotPlainError
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
            raise NotPlainError
        for alias in statement.names:
            if alias.name == "*":
                raise NotPlainError
            self.names[alias.asname or alias.name] = getattr(self._module(statement.module), alias.name)

    def _module(self, name: str) -> ModuleType:
        if name.partition(".")[0] not in ROOTS:
            raise NotPlainError
        if name not in self.modules:
            self.modules[name] = StandInModule(name, self.recorder, self.modules)
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
            raise NotPlainError
        self.names[target.id] = value

    def _If(self, statement: ast.If) -> None:
        branches = statement.body, statement.orelse
        taken, other = branches if self.value(statement.test) else branches[::-1]
        if any(called(node) in BUILDING for part in other for node in ast.walk(part)):
            raise NotPlainError  # a run tells what is not built
        self.block(taken)

    def value(self, node: ast.expr) -> Any:
        """Of an expression."""
        match node:
            case ast.Constant():
                return node.value
            case ast.Name() if node.id in self.names:
                return self.names[node.id]
            case ast.JoinedStr():
                return "".join(self._part(part) for part in node.values)
            case ast.List():
                return [self.value(item) for item in node.elts]
            case ast.Tuple():
                return tuple(self.value(item) for item in node.elts)
            case ast.Dict():
                pairs = zip(node.keys, node.values, strict=True)
                return {self.value(key or _no()): self.value(value) for key, value in pairs}
            case ast.UnaryOp(op=ast.USub()):
                return -self._typed(node.operand, int | float)
            case ast.BinOp(op=ast.Add()):
                return self._sum(self.value(node.left), self.value(node.right))
            case ast.Compare(ops=[ast.Eq()]):
                return self._typed(node.left, str) == self._typed(node.comparators[0], str)
            case ast.Attribute():
                return self._attribute(node)
            case ast.Call():
                return self._called(node)
        raise NotPlainError

    def _part(self, part: ast.expr) -> str:
        if isinstance(part, ast.FormattedValue):
            if part.format_spec is not None or part.conversion != -1:
                raise NotPlainError
            return str(self._typed(part.value, str | int | float))
        return str(self.value(part))

    def _sum(self, left: Any, right: Any) -> Any:
        if type(left) is not type(right) or not isinstance(left, str | int | float | list):
            raise NotPlainError
        return left + right

    def _typed(self, node: ast.expr, kinds: type | UnionType) -> Any:
        value = self.value(node)
        if not isinstance(value, kinds):
            raise NotPlainError
        return value

    def _attribute(self, node: ast.Attribute) -> Any:
        owner = self.value(node.value)
        if node.attr.startswith("_") or not _ours(owner):
            raise NotPlainError
        return getattr(owner, node.attr)

    def _called(self, node: ast.Call) -> Any:
        before, self.call = self.call, node
        function = self.value(node.func)
        if function is not float and not _ours(function):
            raise NotPlainError
        arguments = [self.value(argument) for argument in node.args]
        named = {keyword.arg or _no(): self.value(keyword.value) for keyword in node.keywords}
        self.call = node
        result = function(*arguments, **named)
        self.call = before
        return result


def _no() -> Any:
    raise NotPlainError


def _ours(thing: Any) -> bool:
    """Whether something is one of the stand-ins, or a function of theirs."""
    if isinstance(thing, StandInModule | StandIn):
        return True
    function = getattr(thing, "func", thing)  # of a method that is one of class and instance
    made_by = function.__module__ if callable(function) and not isinstance(thing, type) else None
    owner = thing if isinstance(thing, type) else type(thing)
    return (made_by or "").startswith(_OURS) or owner.__module__.startswith(_OURS) or owner.__name__ == "Controller"
