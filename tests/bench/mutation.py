"""Small faults in the syntax tree of a module: a sign, a bound, a call that is missing, a constant, an order."""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Iterator
from typing import Any

KINDS = ("sign", "bound", "call", "constant", "order")
SIGNS: dict[type[ast.AST], type[ast.operator]] = {ast.Add: ast.Sub, ast.Sub: ast.Add}
BOUNDS: dict[type[ast.AST], type[ast.cmpop]] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
BODIES = ("body", "orelse", "handlers", "finalbody", "cases")
SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
UNCHANGED = (*SCOPES, ast.Raise, ast.Assert, ast.Import, ast.ImportFrom)  # messages, and names
SEQUENCES = (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp, ast.Dict)
NO_EFFECT = re.compile(r"if .*TYPE_CHECKING|[\"']|print\(|.*\b(warn|info|debug|log)\(")
Place = tuple[str, list[ast.stmt], int]  # a qualified name, and a statement in a body


def places(node: ast.AST, function: str = "") -> Iterator[Place]:
    """All statements below a node."""
    for name in BODIES:
        body: list[Any] = getattr(node, name, None) or []
        for index, one in enumerate(body if isinstance(body, list) else ()):
            if isinstance(one, ast.stmt):
                yield function, body, index
            yield from places(one, f"{function}.{one.name}".strip(".") if isinstance(one, SCOPES) else function)


def head(statement: ast.stmt) -> ast.stmt:
    """A copy of a statement; the bodies of a compound one are left out."""
    shell = copy.copy(statement)
    for name in BODIES:
        if isinstance(getattr(shell, name, None), list):
            setattr(shell, name, [ast.Pass()] if name == "body" else [])
    return copy.deepcopy(shell)


def text(statements: list[ast.stmt]) -> str:
    """The lines of statements without their bodies."""
    return "\n".join(ast.unparse(head(one)) for one in statements)


def inner(node: ast.AST) -> Iterator[ast.AST]:
    """A node and the nodes below it, apart from f-strings."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.JoinedStr):
            yield from inner(child)


def edit(node: ast.AST) -> str:
    """Change a node in place, and return the kind of the change, or an empty text."""
    if isinstance(node, ast.BinOp | ast.AugAssign):
        sides = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.value,)
        words = any(isinstance(side, SEQUENCES) or isinstance(getattr(side, "value", 0), str) for side in sides)
        if type(node.op) in SIGNS and not words:
            node.op = SIGNS[type(node.op)]()
            return "sign"
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and not words:
            node.left = ast.UnaryOp(ast.USub(), node.left)
            return "sign"
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in BOUNDS:
        node.ops[0] = BOUNDS[type(node.ops[0])]()
        return "bound"
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
        node.value = node.value + 1 if isinstance(node.value, int) else node.value * 2 + 0.1
        return "constant"
    elif (
        isinstance(node, ast.Call)
        and len({ast.dump(one) for one in node.args[:2] if not isinstance(one, ast.Starred)}) == 2
    ):
        node.args[:2] = node.args[1::-1]
        return "order"
    return ""


def mutants(body: list[ast.stmt], index: int) -> Iterator[tuple[str, str, str]]:
    """The kind, the text before and the text after of each mutant that starts at a statement."""
    statement, following = body[index], body[index + 1 : index + 2]
    if isinstance(statement, UNCHANGED) or NO_EFFECT.match(before := text([statement])):
        return
    if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call):
        yield "call", before, "pass"
    for number, _ in enumerate(inner(head(statement))):
        changed = head(statement)
        if kind := edit([*inner(changed)][number]):
            yield kind, before, text([changed])
    if following and all(isinstance(one, ast.Assign | ast.AugAssign | ast.Expr) for one in (statement, *following)):
        words = [{*re.findall(r"[A-Za-z_]\w+", text([one]))} - {"self", "None"} for one in (statement, *following)]
        if words[0] & words[1]:
            yield "order", text([statement, *following]), text([*following, statement])


def replaced(tree: ast.Module, function: str, before: str, after: str) -> bool:
    """Whether a function of a module has a statement, or two, of this text; they are replaced, and keep their bodies."""
    for name, body, index in places(tree):
        for size in (1, 2) if function in (name, name.split(".")[-1]) else ():
            if text(body[index : index + size]) == before:
                new = ast.parse(after).body
                for part in BODIES if hasattr(new[0], "body") else ():
                    setattr(new[0], part, getattr(body[index], part, []))
                body[index : index + size] = new
                return True
    return False
