"""Conditions: expressions over readings of a session, such as `tilt("dd100") < 0.1`, evaluated to samples with a margin.

Numeric operands of comparisons are compiled once to plain Python, after each of their parts is checked to be harmless. The
`FieldGuard` of `graphengine.sandbox.expressions` evaluates all other operands, such as fields of messages.
"""

from __future__ import annotations

import ast
import contextlib
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from graphengine.api.expectations.comparisons import COMPARISONS, ORDERS, at_most, below, certain, compared, joined
from graphengine.api.expectations.operators import Sample
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.stateful import Stateful
from graphengine.format.wording import printable, shown
from graphengine.sandbox.expressions import FUNCTIONS, FieldGuard, ForbiddenError, compiled

Kind = Literal["number", "vector", "record", "other"]
"""`number` is a bool, int or float, `vector` a tuple or array of numbers, `record` an object with fields of these kinds."""

MAX_EXPONENT = 16
"""Largest exponent of powers that plain Python computes, as floats; the guard computes other powers and limits their size."""
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
    """A reading has no value yet, for example because no message has arrived on its topic."""


class ReadingState(Stateful):
    """The state of a reading between ticks; checkpoints contain it."""

    @abstractmethod
    def reset(self) -> None:
        """Restart at the current time, after a reset of the time."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A value of the session that an expression reads.

    Attributes:
        read: returns the current value, or raises NoValueError.
        kind: kind of the value.
        fields: kinds of the fields of a record.
        state: state between ticks; None for a reading without state.
    """

    read: Callable[[], Any]
    kind: Kind = "number"
    fields: Mapping[str, Kind] = field(default_factory=dict)
    state: ReadingState | None = None


Readings = Mapping[str, Callable[..., Reading]]
"""Functions that expressions can call, by name; each takes the constant arguments of a call and returns the reading."""


def parse(text: str, readings: Iterable[str]) -> ast.expr:
    """Return the syntax tree of an expression, which may use only these readings, `FUNCTIONS` and permitted syntax.

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
        """States of the readings that have one."""
        self._evaluate = self._compiled(tree)

    def number(self) -> float | None:
        """Return the current value; None while a reading has no value.

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
        except Exception as error:  # functions and operators fail in many ways on unexpected values
            raise UsageError(f"{printable(self.text)}: {error}") from None

    def values(self) -> dict[str, Any]:
        """Return the current value of each reading that has one, by the text of the reading in the expression."""
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
                return FieldGuard().evaluate(code, names)

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
    `and` has the smallest margin of its parts, `or` the largest one, and `not` the negated one. All other values have an infinite
    margin. All parts are evaluated in every tick, so the condition has no value while one of its readings has none.

    >>> Condition("1 < limit() and limit() <= 4", {"limit": lambda: Reading(lambda: 3.0)}).sample()
    Sample(holds=True, margin=1.0)
    """

    def sample(self) -> Sample | None:
        """Return the current value with its margin; None while a reading has no value.

        Raises:
            UsageError: the evaluation failed, for example because of a division by zero.
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
    """Return the value of a constant index; None if the index is not a constant integer."""
    try:
        value = ast.literal_eval(index)
    except ValueError:
        return None
    return value if type(value) is int else None


class _Binder(ast.NodeTransformer):
    """Replaces each distinct reading in a syntax tree with a unique name."""

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
            except Exception as error:  # wrong number or types of arguments
                raise ValueError(str(error).replace(f"{function}()", function)) from None
            self.names[text] = f"reading_{len(self.bound)}"
            self.bound[self.names[text]] = reading
        return ast.copy_location(ast.Name(self.names[text], ast.Load()), node)


class _Caller(ast.NodeTransformer):
    """Replaces the name of each reading with a call of its function, and the base of each power with a float of fixed size."""

    def __init__(self, bound: Mapping[str, Reading]) -> None:
        self._bound = bound

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return ast.Call(node, [], []) if node.id in self._bound else node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Pow):
            node.left = ast.BinOp(node.left, ast.Mult(), ast.Constant(1.0))
        return node
