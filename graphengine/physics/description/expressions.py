"""Python expressions of xacro files, without the ways out of an expression.

xacro hands what stands in `${…}` to `eval`. Python's builtins are taken away, yet any attribute of any object leads back to
them: `().__class__`, `(lambda: 0).__globals__`, a generator's `gi_frame`, a format string. So only syntax that is known is
compiled, and every attribute is looked up by `attribute`, which knows what xacro's files need: namespaces, YAML data, and methods
of text, lists and mappings that give away nothing. Time and memory are bounded by the process that this runs in.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from types import CodeType
from typing import Any

_VALUES = "Constant Name Load Attribute Subscript Slice List Tuple Set Dict Starred JoinedStr FormattedValue"
_OPERATIONS = "BinOp operator UnaryOp unaryop BoolOp boolop Compare cmpop IfExp Call keyword Lambda arguments arg"
_LOOPS = "ListComp SetComp DictComp GeneratorExp comprehension Store"
_SYNTAX = tuple(getattr(ast, name) for name in f"Expression {_VALUES} {_OPERATIONS} {_LOOPS}".split())
_TEXT = "split rsplit splitlines join strip lstrip rstrip lower upper title capitalize startswith endswith replace find rfind"
_MORE_TEXT = (
    "index count isdigit isalpha isalnum isspace zfill partition rpartition removeprefix removesuffix ljust rjust"
)
_LIST = "index count append extend insert remove pop reverse sort copy clear"
_MAPPING = "get keys values items copy update pop setdefault"
_SET = "union intersection difference issubset issuperset add discard"
METHODS: Mapping[type, frozenset[str]] = {
    str: frozenset(f"{_TEXT} {_MORE_TEXT}".split()),
    list: frozenset(_LIST.split()),
    tuple: frozenset(("index", "count")),
    dict: frozenset(_MAPPING.split()),
    set: frozenset(_SET.split()),
    frozenset: frozenset(_SET.split()),
    int: frozenset(("real", "imag")),
    float: frozenset(("real", "imag", "is_integer")),
    complex: frozenset(("real", "imag")),
}
"""Attributes by type of value. Text has no `format`: its fields reach attributes too."""

GUARD = "@attribute"
"""The guard's name in compiled code, which no source text can write."""


class ForbiddenError(Exception):
    """An expression that is not evaluated."""


def evaluate(expression: str, names: dict[str, Any]) -> Any:
    """The value of an expression over `names`, which may be a mapping that computes its values.

    Raises:
        ForbiddenError: it uses syntax, a name or an attribute that is not allowed.
        Exception: whatever evaluating it raises.
    """
    names.update(__builtins__={GUARD: attribute})
    return eval(_compile(expression), names)


def attribute(value: Any, name: str) -> Any:
    """What `value.name` means."""
    if isinstance(value, dict) and name not in METHODS[dict]:
        try:
            return value[name]  # xacro's namespaces and YAML mappings
        except (KeyError, AttributeError):
            raise NameError(f"there is no {name!r} in it") from None
    for kind, methods in METHODS.items():
        if isinstance(value, kind) and name in methods:
            return getattr(value, name)
    raise ForbiddenError(f"the attribute {name!r} of a {type(value).__name__} is not allowed in an expression")


def _compile(expression: str) -> CodeType:
    tree = ast.parse(expression.strip(), "<expression>", "eval")
    for node in ast.walk(tree):
        if not isinstance(node, _SYNTAX):
            raise ForbiddenError(f"{type(node).__name__} is not allowed in an expression")
        if isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load):
            raise ForbiddenError("an expression sets no attributes")
        if isinstance(node, ast.Name | ast.arg | ast.keyword | ast.Attribute) and _name(node).startswith("__"):
            raise ForbiddenError(f"the name {_name(node)!r} is not allowed in an expression")
    return compile(ast.fix_missing_locations(_Guarded().visit(tree)), "<expression>", "eval")


def _name(node: ast.Name | ast.arg | ast.keyword | ast.Attribute) -> str:
    if isinstance(node, ast.Name):
        return node.id
    return (node.attr if isinstance(node, ast.Attribute) else node.arg) or ""


class _Guarded(ast.NodeTransformer):
    """Turns `value.name` into a call of the guard."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        self.generic_visit(node)
        return ast.Call(ast.Name(GUARD, ast.Load()), [node.value, ast.Constant(node.attr)], [])
