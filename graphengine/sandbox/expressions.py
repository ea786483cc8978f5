"""Evaluates untrusted Python expressions that can access only the given names.

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
"""Maximum length of an expression, characters."""
MAX_DEPTH = 100
"""Maximum depth of the syntax tree of an expression."""
MAX_STEPS = 1_000_000
"""Maximum number of steps of one guard: loop iterations, calls, and elements of all operands and results."""
MAX_BITS = 10_000
"""Maximum size of an integer that an operator computes, bits."""


def syntax(names: str) -> tuple[type[ast.AST], ...]:
    """Return the classes of the module `ast` with these names, which are separated by spaces."""
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
    "sum": lambda values: sum(values),  # without `start`: `sum(lists, [])` would join lists without a limit
}
"""Functions and constants that an expression may use by default. No function returns a large result for small arguments."""

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
"""Names of the allowed attributes, by type of the value. `str.format` is missing, because its fields can read attributes."""

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
    """An expression is not allowed, or exceeds a limit."""


class Guard:
    """Executes the operations of an expression within limits. Subclasses can allow other attributes and forbid operations.

    A guard allows `MAX_STEPS` in total, for one evaluation or for several evaluations that share the guard.
    """

    methods: Mapping[type, frozenset[str]] = METHODS

    def __init__(self) -> None:
        self._left = MAX_STEPS
        names = ("attribute", "call", "operate", "iterate", "format", "made")
        self._guards = {f"@{name}": getattr(self, name) for name in names}  # no source text can contain these names

    def evaluate(self, code: CodeType, names: dict[str, Any]) -> Any:
        """Return the value of a compiled expression.

        Args:
            code: result of `compiled`.
            names: values of the names in the expression; a subclass of dict may compute them. Receives `__builtins__`.

        Raises:
            ForbiddenError: the expression reads a forbidden attribute, or exceeds a limit.
            Exception: any other exception that the evaluation raises.
        """
        names.update(__builtins__=self._guards)
        return eval(code, names)

    def attributes(self, value: Any) -> Collection[str]:
        """Return the names of a value's attributes that an expression may read."""
        return next((names for kind, names in self.methods.items() if isinstance(value, kind)), ())

    def attribute(self, value: Any, name: str) -> Any:
        """Return the attribute `name` of a value; raise ForbiddenError if it is not allowed."""
        if name not in (legal := self.attributes(value)):
            what = f"the attribute {name!r} of a {type(value).__name__} is not allowed in an expression"
            raise ForbiddenError(f"{what}\n{did_you_mean(name, legal) or listing(sorted(legal))}")
        return getattr(value, name)

    def call(self, place: tuple[int, int, int], function: Any, /, *arguments: Any, **named: Any) -> Any:
        """Return the result of a function call; `place` is the first line, last line and column of the call."""
        if "key" in named:  # functions such as `sorted` would call the key in loops that are not counted
            raise ForbiddenError("the argument `key` is not allowed in an expression")
        digits = (*arguments[1:], *named.values()) if function is round else ()
        if any(isinstance(number, int) and -number > MAX_BITS for number in digits):
            text = f"rounding to more than {MAX_BITS} digits before the point is not allowed in an expression"
            raise ForbiddenError(text)
        self.spend(1)
        self.weigh(getattr(function, "__self__", None), *arguments, *named.values())
        return self.made(function(*arguments, **named))

    def operate(self, name: str, /, *operands: Any) -> Any:
        """Return the result of the operator `name`, which is a class name in `ast`, such as `Add`."""
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
        """Yield the values over which a comprehension loops, and count each as a step."""
        for value in values:
            self.spend(1)
            yield value

    def format(self, value: Any, conversion: int, form: str) -> str:
        """Return the text of a value in an f-string; `conversion` is the code of `s`, `r` or `a`, or -1."""
        if _WIDE.search(form):
            raise ForbiddenError("a format field of more than 999 characters is not allowed in an expression")
        self.weigh(value)
        return format(_CONVERSIONS[conversion](value) if conversion in _CONVERSIONS else value, form)

    def made(self, value: Any) -> Any:
        """Count the steps of a computed or compared value, and return the value."""
        self.weigh(value)
        return value

    def weigh(self, *values: Any) -> None:
        """Count the steps of values and of all nested elements; an element that occurs repeatedly is counted each time.

        Arrays of several dimensions are refused: an operation of two of them can have a result that is larger than both.
        """
        pending = [*values]
        for part in pending:
            if getattr(part, "ndim", 0) > 1:
                text = "an array of several dimensions is not allowed in an expression; write an index for each"
                raise ForbiddenError(text)
            self.spend(cost(part))
            if isinstance(part, _COLLECTIONS) and not isinstance(part, str | bytes):
                pending.extend(part)
                pending.extend(part.values() if isinstance(part, dict) else ())

    def spend(self, steps: int) -> None:
        """Subtract steps from the remaining number.

        Raises:
            ForbiddenError: more than `MAX_STEPS` steps were counted.
        """
        self._left -= steps
        if self._left < 0:
            raise ForbiddenError(f"an expression may take at most {MAX_STEPS} steps")


class FieldGuard(Guard):
    """Lets expressions read the fields of messages and of other records."""

    def attribute(self, value: Any, name: str) -> Any:
        """Return the attribute `name` of a value; raise ForbiddenError if it is not allowed."""
        if name in getattr(value, "__dataclass_fields__", ()) and not name.startswith("_"):
            return getattr(value, name)
        return super().attribute(value, name)

    def attributes(self, value: Any) -> Collection[str]:
        """Return the names of a value's attributes that an expression may read: of a record, its fields."""
        if hasattr(value, "__dataclass_fields__"):
            return [name for name in value.__dataclass_fields__ if not name.startswith("_")]
        return super().attributes(value)


def cost(value: Any) -> int:
    """Return the steps of a value without its elements: 1 per 64 bits, characters or numbers, or 1 per collection element."""
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
        known: names that the expression may use in addition to its loop variables; None: all names that do not begin with `__`.

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
        raise ForbiddenError(f"there is no name {unknown[0]!r}\n{near}")
    guarded: ast.Expression = _guarded(tree)
    return compile(ast.fix_missing_locations(guarded), "<expression>", "eval")


def _parsed(text: str) -> ast.Expression:
    if len(text) > MAX_CHARACTERS:
        raise ForbiddenError(f"an expression may have at most {MAX_CHARACTERS} characters")
    try:
        return ast.parse(text.strip(), "<expression>", "eval")
    except (MemoryError, RecursionError):
        raise ForbiddenError(f"an expression may be nested at most {MAX_DEPTH} levels deep") from None


def _nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a syntax tree, level by level.

    Raises:
        ForbiddenError: the tree has more than `MAX_DEPTH` levels.
    """
    level = [tree]
    for _ in range(MAX_DEPTH):
        yield from level
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return
    raise ForbiddenError(f"an expression may be nested at most {MAX_DEPTH} levels deep")


def _guarded(part: Any) -> Any:
    """Return a copy of a syntax tree in which each operation is replaced by a call of the guard."""
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
