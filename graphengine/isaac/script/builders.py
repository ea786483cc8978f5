"""Finds the builders in a script: functions and methods that edit graphs themselves or call another builder."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from typing import NamedTuple

BUILDING = frozenset(("edit", "create_node", "create_graph"))
"""Names of the methods of OmniGraph's controllers that create graphs or nodes."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Builder(NamedTuple):
    """A function or method that builds graphs.

    Attributes:
        name: name of the function; for `__init__`, the name of the class.
        text: example call with the parameters as arguments, such as `Robot(path).build(rate=2)`.
        calls: names of the functions and methods that the function calls.
        node: definition of the function.
    """

    name: str
    text: str
    calls: set[str]
    node: Function


def builders(*trees: ast.Module, foreign: Collection[str] = ()) -> list[Builder]:
    """Return all builders in the syntax trees of a script and its modules; calls of `foreign` modules are ignored."""
    functions = [function for tree in trees for node in tree.body for function in _functions(node, foreign)]
    building: list[Builder] = []
    while True:
        names = BUILDING | {builder.name for builder in building}
        more = [function for function in functions if function.calls & names]
        if len(more) == len(building):
            return building
        building = more


def entries(tree: ast.Module, foreign: Collection[str]) -> list[Builder]:
    """Return the builders that no other builder calls, or all builders if another builder calls each of them."""
    building = builders(tree, foreign=foreign)
    called = {name for builder in building for name in builder.calls - {builder.name}}
    return [builder for builder in building if builder.name not in called] or building


def handed_over(tree: ast.Module) -> set[str]:
    """Return the names that a script uses without calling them directly, such as functions that it passes as callbacks."""
    nodes, later = list(ast.walk(tree)), _in_lambdas(tree)
    made = {id(node.func) for node in nodes if isinstance(node, ast.Call) and id(node) not in later}
    used = (node for node in nodes if isinstance(node, ast.Name | ast.Attribute) and id(node) not in made)
    return {str(getattr(node, "id", getattr(node, "attr", ""))) for node in used}


def called(call: ast.AST, foreign: Collection[str] = ()) -> str:
    """Return the name of the function or method that a call expression calls: `build` for `robot.build()`.

    For all other expressions, and for calls of functions in `foreign` modules, return an empty string.
    """
    function = getattr(call, "func", None)
    owner = getattr(function, "value", function)
    if getattr(owner, "id", "") in foreign:
        return ""
    return str(getattr(function, "id", getattr(function, "attr", "")))


def _functions(node: ast.stmt, foreign: Collection[str], owner: str = "", instance: str = "") -> Iterator[Builder]:
    """Yield each function or method that a statement of a module or class defines.

    Args:
        node: statement.
        foreign: modules whose functions do not build graphs.
        owner: name of the class around the statement, if any.
        instance: example code that creates an instance of this class.
    """
    if isinstance(node, ast.ClassDef):
        start = next((part for part in node.body if isinstance(part, Function) and part.name == "__init__"), None)
        for part in node.body:
            yield from _functions(part, foreign, node.name, f"{node.name}({_arguments(start, 1) if start else ''})")
    elif isinstance(node, Function):
        kinds = {getattr(kind, "id", "") for kind in node.decorator_list}
        text = f"{node.name}({_arguments(node, int(bool(owner) and 'staticmethod' not in kinds))})"
        if owner:
            text = f"{owner if kinds & {'staticmethod', 'classmethod'} else instance}.{text}"
        later = _in_lambdas(node)
        calls = {called(part, foreign) for part in ast.walk(node) if id(part) not in later} - {""}
        makes = bool(owner) and node.name == "__init__"
        yield Builder(owner if makes else node.name, instance if makes else text, calls, node)


def _in_lambdas(tree: ast.AST) -> set[int]:
    """Return the `id()` of all syntax nodes in lambdas, which run only when the lambda is called."""
    return {id(part) for node in ast.walk(tree) if isinstance(node, ast.Lambda) for part in ast.walk(node)}


def _arguments(function: Function, first: int) -> str:
    """Return the parameter list of a function as text, without the first `first` positional parameters."""
    return ast.unparse(ast.arguments(**{**vars(function.args), "args": function.args.args[first:]}))
