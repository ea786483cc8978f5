"""Conditions: expressions over readings of a session, such as `tilt("dd100") < 0.1`, evaluated as samples with a margin.

Sides of comparisons that consist of numbers are compiled to plain Python once, after every part was found to be harmless. The
`Guard` of `graphengine.sandbox.expressions` evaluates the others, such as those with fields of messages.
"""

from __future__ import annotations

import ast
import contextlib
from abc import abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from graphengine.api.expectations.comparisons import COMPARISONS, ORDERS, at_most, below, certain, compared, joined
from graphengine.api.expectations.operators import Sample
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.stateful import Stateful
from graphengine.format.wording import printable, shown
from graphengine.sandbox.expressions import FUNCTIONS, ForbiddenError, Guard, compiled

Kind = Literal["number", "vector", "record", "other"]
"""`number` is a bool, int or float, `vector` a tuple or array of numbers, `record` an object with fields of these kinds."""

MAX_EXPONENT = 16
"""Largest exponent in plain Python, whose powers are floats; the guard computes others, and limits their size."""
_NUMERIC = (
    "abs",
    "atan2",
    "ceil",
    "cos",
    "degrees",
    "floor",
    "hypot",
    "isfinite",
    "isnan",
    "radians",
    "sin",
    "sqrt",
    "tan",
)
_COLLECTIVE = ("len", "max", "min", "sum")
_CONSTANTS = ("e", "inf", "nan", "pi", "tau")
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod)


class NoValueError(Exception):
    """A reading has no value yet, such as the message of a topic on which none has arrived."""


class ReadingState(Stateful):
    """What a reading remembers between ticks; checkpoints contain it."""

    @abstractmethod
    def reset(self) -> None:
        """Begin anew at the present time, because the time was reset."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A value of the session that an expression reads.

    Attributes:
        read: returns the present value, or raises NoValueError.
        kind: kind of the value.
        fields: kinds of the fields of a record.
        state: what the reading remembers between ticks; None if it remembers nothing.
    """

    read: Callable[[], Any]
    kind: Kind = "number"
    fields: Mapping[str, Kind] = field(default_factory=dict)
    state: ReadingState | None = None


Readings = Mapping[str, Callable[..., Reading]]
"""Functions of expressions by name; a function gets the constant arguments of a call and returns the reading."""


def parse(text: str, readings: Iterable[str]) -> ast.expr:
    """Return the syntax tree of an expression that only uses these readings and functions, and no forbidden syntax.

    Raises:
        UsageError: the text is not a legal expression.
    """
    try:
        compiled(text, known=(*readings, *FUNCTIONS))
        return ast.parse(text.strip(), mode="eval").body
    except SyntaxError as error:
        place = f"\n  {printable(text.strip())}\n  {' ' * ((error.offset or len(text.strip()) + 1) - 1)}^"
        raise UsageError(f"not an expression: {error.msg}{place}") from None
    except (ForbiddenError, ValueError) as error:
        raise UsageError(f"{printable(text)}: {error}") from None


class Expression:
    """An expression over readings of a session.

    >>> Expression("2 * limit()", {"limit": lambda: Reading(lambda: 3.0)}).number()
    6.0

    Args:
        text: the expression.
        readings: functions that the expression may use.

    Raises:
        UsageError: the text is not a legal expression, or a reading refuses its arguments.
    """

    def __init__(self, text: str, readings: Readings) -> None:
        self.text = text
        binder = _Binder(readings)
        tree = parse(text, readings)
        try:
            tree = binder.visit(tree)
        except ValueError as error:
            raise UsageError(f"{printable(text)}: {error}") from None
        self._bound = binder.bound
        self._names = binder.names
        self.states = [reading.state for reading in binder.bound.values() if reading.state is not None]
        """What the readings remember between ticks."""
        self._evaluate = self._compiled(tree)

    def number(self) -> float | None:
        """Return the present value; None while a reading has no value.

        Raises:
            UsageError: the value is not a number, or the expression has no value.
        """
        value = self._read()
        if value is not None and not isinstance(value, bool | int | float | np.number):
            raise UsageError(f"{self.text}: expected a number, got {shown(value)}")
        return None if value is None else float(value)

    def _read(self) -> Any:
        try:
            return self._evaluate()
        except NoValueError:
            return None
        except GraphError:
            raise
        except Exception as error:  # of functions and operators that get other values than they expect
            raise UsageError(f"{printable(self.text)}: {error}") from None

    def values(self) -> dict[str, Any]:
        """Return the present value of each reading, by its text in the expression; those without a value are left out."""
        found = {}
        for text, name in self._names.items():
            with contextlib.suppress(NoValueError):
                found[text] = self._bound[name].read()
        return found

    def _compiled(self, tree: ast.expr) -> Callable[[], Any]:
        """Return the function that evaluates the whole expression."""
        return self._value(tree)

    def _value(self, node: ast.expr) -> Callable[[], Any]:
        """Return the function that evaluates an operand: plain Python if it consists of numbers, else a call of the guard."""
        if isinstance(node, ast.Name) and node.id in self._bound:
            return self._bound[node.id].read
        if self._kind(node) == "other":
            used = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)} & {*self._bound}
            code, names, reads = compiled(node), dict(FUNCTIONS), {name: self._bound[name].read for name in used}

            def evaluate() -> Any:
                for name, read in reads.items():
                    names[name] = read()
                return _FieldGuard().evaluate(code, names)

            return evaluate
        return self._plain(node)

    def _plain(self, node: ast.expr) -> Callable[[], Any]:
        """Compile an operand that consists of numbers, or a call of a function of `ORDERS`, to plain Python."""
        body = ast.Lambda(ast.arguments([], [], None, [], [], None, []), _Caller(self._bound).visit(node))
        names: dict[str, Any] = {"_below": below, "_at_most": at_most}
        names |= {name: FUNCTIONS[name] for name in (*_NUMERIC, *_COLLECTIVE, *_CONSTANTS)}
        names |= {name: reading.read for name, reading in self._bound.items()}
        function: Callable[[], Any] = eval(
            compile(ast.fix_missing_locations(ast.Expression(body)), "<expression>", "eval"),
            {**names, "__builtins__": {}},
        )
        return function

    def _kind(self, node: ast.expr) -> Kind:
        """Return the kind of an expression's value; `other` if plain Python must not compute it."""
        match node:
            case ast.Constant(value=bool() | int() | float()):
                return "number"
            case ast.Name(id=name) if name in self._bound:
                return self._bound[name].kind
            case ast.Name(id=name) if name in _CONSTANTS:
                return "number"
            case ast.Attribute(value=ast.Name(id=name), attr=attribute) if name in self._bound:
                return self._bound[name].fields.get(attribute, "other")
            case ast.Subscript(slice=index) if _whole(index) is not None and self._kind(node.value) == "vector":
                return "number"
            case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
                return self._number(node.operand)
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(power))) if power <= MAX_EXPONENT:
                nested = any(isinstance(part, ast.Pow) for part in ast.walk(node.left))
                return "other" if nested else self._number(node.left)
            case ast.BinOp() if isinstance(node.op, _OPERATORS):
                return self._number(node.left, node.right)
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _NUMERIC:
                return self._number(*node.args)
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _COLLECTIVE:
                known = all(self._kind(argument) in ("number", "vector") for argument in node.args)
                return "number" if known else "other"
        return "other"

    def _number(self, *nodes: ast.expr) -> Kind:
        return "number" if all(self._kind(node) == "number" for node in nodes) else "other"


class Condition(Expression):
    """An expression whose value is true or false, with a margin.

    The margin of a comparison of numbers is the difference of its sides; of an equality, the negative absolute difference.
    `and` has the smaller margin of its parts, `or` the larger one, and `not` the opposite one. All other values have an infinite
    margin. All parts are evaluated in every tick: a reading without a value leaves the whole condition without one.

    >>> Condition("1 < limit() and limit() <= 4", {"limit": lambda: Reading(lambda: 3.0)}).sample()
    Sample(holds=True, margin=1.0)
    """

    def sample(self) -> Sample | None:
        """Return the present value with its margin; None while a reading has no value.

        Raises:
            UsageError: the expression has no value, for example because of a division by zero.
        """
        sample: Sample | None = self._read()
        return sample

    def _compiled(self, tree: ast.expr) -> Callable[[], Sample]:
        return self._sampled(tree)

    def _sampled(self, node: ast.expr) -> Callable[[], Sample]:
        """Return the function that evaluates a condition."""
        match node:
            case ast.BoolOp():
                parts = [self._sampled(part) for part in node.values]
                return joined(parts, *((all, min) if isinstance(node.op, ast.And) else (any, max)))
            case ast.UnaryOp(op=ast.Not()):
                part = self._sampled(node.operand)
                return lambda: part().inverted()
            case ast.Compare(ops=[op]) if type(op) in ORDERS and self._number(node.left, *node.comparators) == "number":
                name, order = ORDERS[type(op)]
                return self._plain(ast.Call(ast.Name(name, ast.Load()), [node.left, *node.comparators][::order], []))
            case ast.Compare() if all(type(op) in COMPARISONS for op in node.ops):
                sides = [self._value(side) for side in (node.left, *node.comparators)]
                return compared([COMPARISONS[type(op)] for op in node.ops], sides)
        value = self._value(node)
        return lambda: certain(bool(value()))


def _whole(index: ast.expr) -> int | None:
    """Return the value of a constant index; None if the index is no constant integer."""
    try:
        value = ast.literal_eval(index)
    except ValueError:
        return None
    return value if type(value) is int else None


class _FieldGuard(Guard):
    """Lets expressions read the fields of messages and of other records."""

    def attribute(self, value: Any, name: str) -> Any:
        if name in getattr(value, "__dataclass_fields__", ()) and not name.startswith("_"):
            return getattr(value, name)
        return super().attribute(value, name)

    def attributes(self, value: Any) -> Collection[str]:
        if hasattr(value, "__dataclass_fields__"):
            return [name for name in value.__dataclass_fields__ if not name.startswith("_")]
        return super().attributes(value)


class _Binder(ast.NodeTransformer):
    """Replaces each use of a reading in a syntax tree by a name of its own."""

    def __init__(self, readings: Readings) -> None:
        self._readings = readings
        self.names: dict[str, str] = {}
        """The names that replace the readings, by the text of each reading."""
        self.bound: dict[str, Reading] = {}
        """The readings by the names that replace them."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if not isinstance(node.func, ast.Name) or node.func.id not in self._readings:
            return self.generic_visit(node)
        try:
            arguments = [ast.literal_eval(argument) for argument in node.args]
            named = {str(keyword.arg): ast.literal_eval(keyword.value) for keyword in node.keywords}
        except (TypeError, ValueError):
            raise ValueError(f"the arguments of {node.func.id} must be constants") from None
        return self._bind(node, node.func.id, arguments, named)

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return self._bind(node, node.id, [], {}) if node.id in self._readings else node

    def _bind(self, node: ast.expr, function: str, arguments: list[Any], named: dict[str, Any]) -> ast.Name:
        text = ast.unparse(node)
        if text not in self.names:
            try:
                reading = self._readings[function](*arguments, **named)
            except GraphError:
                raise
            except Exception as error:  # of arguments of another type or number than the function expects
                raise ValueError(str(error).replace(f"{function}()", function)) from None
            self.names[text] = f"reading_{len(self.bound)}"
            self.bound[self.names[text]] = reading
        return ast.copy_location(ast.Name(self.names[text], ast.Load()), node)


class _Caller(ast.NodeTransformer):
    """Replaces the name of each reading by a call of its function, and the base of each power by a float, which stays small."""

    def __init__(self, bound: Mapping[str, Reading]) -> None:
        self._bound = bound

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.Call(node, [], []) if node.id in self._bound else node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Pow):
            node.left = ast.BinOp(node.left, ast.Mult(), ast.Constant(1.0))
        return node
