"""Evaluates untrusted Python expressions without access to anything outside them.

In plain Python, attributes of any object lead to the interpreter's internals: `().__class__`, `(lambda: 0).__globals__`, a
generator's `gi_frame`, a format string. A few characters can use all memory: `9**9**9`. So `compiled` accepts only known
syntax, and its code leaves attributes, calls, operators, loops and formatting to a `Guard`, which limits them:

    code = compiled("max(m.ranges) > 2 * limit", known=("m", "limit", *FUNCTIONS))
    Guard().evaluate(code, {"m": message, "limit": 0.5, **FUNCTIONS})
"""

from __future__ import annotations

import ast
import builtins
import math
import operator
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from types import CodeType
from typing import Any

from graphengine.format.wording import did_you_mean, listing

MAX_CHARACTERS = 100_000
"""Of an expression."""
MAX_DEPTH = 100
"""Levels of an expression's syntax tree."""
MAX_STEPS = 1_000_000
"""That one guard allows in all: turns of loops, calls, and elements of what is computed and what it is computed from."""
MAX_BITS = 10_000
"""Of a whole number that an operator computes."""


def syntax(names: str) -> tuple[type[ast.AST], ...]:
    """Return the classes of the module `ast` with these names."""
    return tuple(getattr(ast, name) for name in names.split())


_VALUES = "Expression Constant Name Load Attribute Subscript Slice List Tuple Set Dict Starred JoinedStr FormattedValue"
_OPERATIONS = "BinOp operator UnaryOp unaryop BoolOp boolop Compare cmpop IfExp Call keyword"
SYNTAX = syntax(f"{_VALUES} {_OPERATIONS} ListComp SetComp DictComp GeneratorExp comprehension Store")

_LEGAL = "legal: values, names, attributes, indices, operators, comparisons, calls, comprehensions, f-strings"

_SAFE = "abs all any bool dict enumerate float int len list max min reversed round set sorted str tuple zip"
_MATHEMATICS = "atan2 ceil cos degrees e floor hypot inf isfinite isinf isnan nan pi radians sin sqrt tan tau"
FUNCTIONS: Mapping[str, Any] = {
    **{name: getattr(builtins, name) for name in _SAFE.split()},
    **{name: getattr(math, name) for name in _MATHEMATICS.split()},
    "sum": lambda values: sum(values),  # of numbers: with a list to start from, it joins lists without a bound
}
"""Functions and constants that an expression may have. None makes more of its arguments than they hold."""

_TEXT = "split rsplit splitlines strip lstrip rstrip lower upper title capitalize startswith endswith find rfind index count"
_SET = frozenset(("union", "intersection", "difference", "issubset", "issuperset"))
METHODS: Mapping[type, frozenset[str]] = {
    str: frozenset(f"{_TEXT} isdigit isalpha isalnum isspace partition rpartition removeprefix removesuffix".split()),
    list: frozenset(("index", "count")),
    tuple: frozenset(("index", "count")),
    dict: frozenset(("get", "keys", "values", "items")),
    set: _SET,
    frozenset: _SET,
    int: frozenset(("real", "imag")),
    float: frozenset(("real", "imag", "is_integer")),
    complex: frozenset(("real", "imag")),
}
"""Attributes by type of value. Text has no `format`: its fields reach attributes too."""

_OPERATORS: Mapping[str, Callable[..., Any]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mult": operator.mul,
    "Div": operator.truediv,
    "FloorDiv": operator.floordiv,
    "Mod": operator.mod,
    "Pow": operator.pow,
    "MatMult": operator.matmul,
    "LShift": operator.lshift,
    "RShift": operator.rshift,
    "BitAnd": operator.and_,
    "BitOr": operator.or_,
    "BitXor": operator.xor,
    "UAdd": operator.pos,
    "USub": operator.neg,
    "Invert": operator.invert,
    "Not": operator.not_,
}
_CONVERSIONS: Mapping[int, Callable[[Any], Any]] = {ord("s"): str, ord("r"): repr, ord("a"): ascii}
_WIDE = re.compile(r"\*|\d{4}")
_WIDE_FIELD = re.compile(r"%\([^)]*\(|%(\([^)]*\))?[#0+ -]*(\d*\.)?(\*|\d{4})")
_COLLECTIONS = (str, bytes, list, tuple, set, frozenset, dict)


class ForbiddenError(Exception):
    """An expression that is not allowed, or exceeds the limits."""


class Guard:
    """Executes the operations of an expression within limits; subclasses decide on attributes and calls, or forbid more.

    A guard allows `MAX_STEPS` in total: for one evaluation, or for several that share the guard.
    """

    methods: Mapping[type, frozenset[str]] = METHODS

    def __init__(self) -> None:
        self._left = MAX_STEPS
        names = ("attribute", "call", "operate", "iterate", "format", "made")
        self._guards = {f"@{name}": getattr(self, name) for name in names}  # which no source text can write

    def evaluate(self, code: CodeType, names: dict[str, Any]) -> Any:
        """Return the value of a compiled expression; `names` may be a mapping that computes its values.

        Raises:
            ForbiddenError: the expression reads a forbidden attribute, or exceeds the limits.
            Exception: any exception that the evaluation raises.
        """
        names.update(__builtins__=self._guards)
        return eval(code, names)

    def attributes(self, value: Any) -> Collection[str]:
        """Return the names of a value's attributes that an expression may read."""
        return next((names for kind, names in self.methods.items() if isinstance(value, kind)), ())

    def attribute(self, value: Any, name: str) -> Any:
        """Return the value of `value.name`."""
        if name not in (legal := self.attributes(value)):
            what = f"the attribute {name!r} of a {type(value).__name__} is not allowed in an expression"
            raise ForbiddenError(f"{what}\n{did_you_mean(name, legal) or listing(sorted(legal))}")
        return getattr(value, name)

    def call(self, place: tuple[int, int, int], function: Any, /, *arguments: Any, **named: Any) -> Any:
        """Call a function; `place` is first line, last line and column of the call."""
        if "key" in named:  # Python calls it in loops of its own, which nobody counts
            raise ForbiddenError("the argument `key` is not allowed in an expression")
        self.spend(1)
        self.weigh(getattr(function, "__self__", None), *arguments, *named.values())
        return self.made(function(*arguments, **named))

    def operate(self, name: str, /, *operands: Any) -> Any:
        """Return the result of an operator, given by its name in the module `ast`."""
        first, last = operands[0], operands[-1]
        if all(isinstance(operand, int) for operand in operands):
            size, other = first.bit_length(), last.bit_length()
            if {"Pow": size * last, "LShift": size + last, "Mult": size + other}.get(name, 0) > MAX_BITS:
                raise ForbiddenError(f"a number of more than {MAX_BITS} bits is not allowed in an expression")
        elif name == "Mult" and any(isinstance(operand, _COLLECTIONS) for operand in operands):
            sizes = (len(part) if isinstance(part, _COLLECTIONS) else operator.index(part) for part in operands)
            self.spend(max(math.prod(sizes), 0))
        elif name == "Mod" and isinstance(first, str | bytes) and _WIDE_FIELD.search(str(first)):
            raise ForbiddenError("a format field of more than 999 characters is not allowed in an expression")
        self.weigh(*operands)
        return self.made(_OPERATORS[name](*operands))

    def iterate(self, values: Iterable[Any]) -> Iterator[Any]:
        """Return the values over which a comprehension loops."""
        for value in values:
            self.spend(1)
            yield value

    def format(self, value: Any, conversion: int, form: str) -> str:
        """Return the text of a value in an f-string."""
        if _WIDE.search(form):
            raise ForbiddenError("a format field of more than 999 characters is not allowed in an expression")
        self.weigh(value)
        return format(_CONVERSIONS[conversion](value) if conversion in _CONVERSIONS else value, form)

    def made(self, value: Any) -> Any:
        """Check a computed or compared value against the limits, and return it."""
        self.weigh(value)
        return value

    def weigh(self, *values: Any) -> None:
        """Count the steps of values and all their elements; a list that occurs a thousand times counts a thousand times."""
        pending = [*values]
        for part in pending:
            self.spend(cost(part))
            if isinstance(part, _COLLECTIONS) and not isinstance(part, str | bytes):
                pending.extend(part)
                pending.extend(part.values() if isinstance(part, dict) else ())

    def spend(self, steps: int) -> None:
        """Count steps.

        Raises:
            ForbiddenError: the limit is exceeded.
        """
        self._left -= steps
        if self._left < 0:
            raise ForbiddenError(f"an expression may take at most {MAX_STEPS} steps")


def cost(value: Any) -> int:
    """Return the steps of a value without its elements; 64 bits, characters or array numbers count as one step."""
    if isinstance(value, int):
        return value.bit_length() // 64
    if isinstance(value, str | bytes):
        return len(value) // 64
    if isinstance(value, _COLLECTIONS):
        return len(value)
    return int(value.size) // 64 if hasattr(value, "__array_interface__") else 0


def compiled(
    expression: str | ast.expr, syntax: tuple[type[ast.AST], ...] = SYNTAX, known: Collection[str] | None = None
) -> CodeType:
    """Compile an expression for `Guard.evaluate`.

    Args:
        expression: text or syntax tree.
        syntax: classes of syntax nodes that are allowed.
        known: names that the expression may use, besides its loop variables; None: any names except Python's own.

    Raises:
        SyntaxError, ValueError: the text is not an expression.
        ForbiddenError: the expression is too large, or uses forbidden syntax or names.
    """
    tree = ast.Expression(expression) if isinstance(expression, ast.expr) else _parsed(expression)
    used: set[str] = set()
    bound: set[str] = set()
    for node in _nodes(tree):
        if not isinstance(node, syntax):
            raise ForbiddenError(f"{type(node).__name__} is not allowed in an expression\n{_LEGAL}")
        if isinstance(node, ast.Attribute | ast.Subscript | ast.Starred) and isinstance(node.ctx, ast.Store):
            raise ForbiddenError("an expression can only assign its loop variables")
        name = str(getattr(node, "id", None) or getattr(node, "attr", None) or getattr(node, "arg", None) or "")
        given = known if known and isinstance(node, ast.Name) else ()
        if name.startswith("__") and (name not in given or name == "__builtins__"):
            raise ForbiddenError(f"the name {name!r} is not allowed in an expression")
        if isinstance(node, ast.Name | ast.arg):
            (used if isinstance(getattr(node, "ctx", None), ast.Load) else bound).add(name)
    unknown = [name for name in sorted(used - bound) if known is not None and name not in known]
    if unknown:
        near = did_you_mean(unknown[0], known or ()) or listing(known or ())
        raise ForbiddenError(f"there is no {unknown[0]!r}\n{near}")
    guarded: ast.Expression = _guarded(tree)
    return compile(ast.fix_missing_locations(guarded), "<expression>", "eval")


def _parsed(text: str) -> ast.Expression:
    if len(text) > MAX_CHARACTERS:
        raise ForbiddenError(f"an expression may have at most {MAX_CHARACTERS} characters")
    try:
        return ast.parse(text.strip(), "<expression>", "eval")
    except (MemoryError, RecursionError):
        raise ForbiddenError(f"an expression is nested at most {MAX_DEPTH} levels deep") from None


def _nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a tree, level by level.

    Raises:
        ForbiddenError: it has too many levels.
    """
    level = [tree]
    for _ in range(MAX_DEPTH):
        yield from level
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return
    raise ForbiddenError(f"an expression is nested at most {MAX_DEPTH} levels deep")


def _guarded(part: Any) -> Any:
    """Return a copy of a syntax tree in which operations are calls of the guard."""
    if isinstance(part, list):
        return [_guarded(item) for item in part]
    if not isinstance(part, ast.AST):
        return part
    node = type(part)(**{name: _guarded(value) for name, value in ast.iter_fields(part)})
    match node:
        case ast.Attribute():
            return _guard("attribute", node.value, ast.Constant(node.attr))
        case ast.Call():
            place: Any = tuple(getattr(part, name) for name in ("lineno", "end_lineno", "col_offset"))
            return _guard("call", ast.Constant(place), node.func, *node.args, keywords=node.keywords)
        case ast.BinOp():
            return _guard("operate", ast.Constant(type(node.op).__name__), node.left, node.right)
        case ast.UnaryOp():
            return _guard("operate", ast.Constant(type(node.op).__name__), node.operand)
        case ast.comprehension():
            node.iter = _guard("iterate", node.iter)
        case ast.FormattedValue():
            form = node.format_spec or ast.Constant("")
            return ast.FormattedValue(_guard("format", node.value, ast.Constant(node.conversion), form), -1)
        case ast.Starred():
            node.value = _guard("made", node.value)
        case ast.Compare():
            node.left = _guard("made", node.left)
            node.comparators = [_guard("made", side) for side in node.comparators]
        case ast.List() | ast.Tuple() if isinstance(node.ctx, ast.Store):
            pass
        case ast.List() | ast.Tuple() | ast.Set() | ast.Dict() | ast.ListComp() | ast.SetComp() | ast.DictComp():
            return _guard("made", node)
        case ast.Subscript() | ast.JoinedStr():
            return _guard("made", node)
    return node


def _guard(name: str, *arguments: ast.expr, keywords: Iterable[ast.keyword] = ()) -> ast.Call:
    return ast.Call(ast.Name(f"@{name}", ast.Load()), [*arguments], [*keywords])
