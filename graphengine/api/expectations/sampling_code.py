"""Generates functions that sample expressions. A generated function evaluates each reading once.

Operands that consist of numbers become plain Python, after each of their parts is checked to be harmless. The `Guard` of
`graphengine.sandbox.expressions` evaluates all other operands, such as texts.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Protocol

from graphengine.api.expectations.comparisons import COMPARISONS, compared, unordered
from graphengine.api.expectations.reading_types import Kind, Reading
from graphengine.sandbox.expressions import FUNCTIONS, FieldGuard, compiled

MAX_EXPONENT = 16
"""Largest exponent of powers that plain Python computes, as floats; the guard computes other powers and limits their size."""
_NUMERIC = (
    *("abs", "atan2", "ceil", "cos", "degrees", "floor", "hypot"),
    *("isfinite", "isnan", "radians", "sin", "sqrt", "tan"),
)
_COLLECTIVE = ("len", "max", "min", "sum")
_CONSTANTS = ("e", "inf", "nan", "pi", "tau")
_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%"}
_SIGNS = {ast.UAdd: "+", ast.USub: "-"}
_ORDERS = {ast.Lt: ("<", 1), ast.LtE: ("<=", 1), ast.Gt: ("<", -1), ast.GtE: ("<=", -1)}
"""For each operator, an operator that compares the smaller side with the larger one, and the step of the sides in this order."""
_OTHER: tuple[Kind, str] = "other", ""
_LARGE = 1e15
"""Absolute value from which a constant is not written as text, because Python limits the length of integers as text."""


class Sampled(Protocol):
    """An expression that generated code samples."""

    @property
    def bound(self) -> Mapping[str, tuple[str, Reading]]:
        """Text and reading of each name in the expression that stands for a reading."""

    def add_to(self, code: SamplingCode) -> list[str]:
        """Add the computation of the value to generated code, and return the names of the variables of the result."""


class SamplingCode:
    """The body of a generated function that samples expressions.

    Args:
        parameters: for each shared value that callers pass to the function, the name of the parameter.
    """

    def __init__(self, **parameters: str) -> None:
        self._parameters = ", ".join(parameters.values())
        self._reads: list[str] = []
        """Statements that assign readings to variables."""
        self._lines: list[str] = []
        """Statements that compute the samples."""
        self._variables: dict[Any, str] = dict(parameters)
        self._arriving: dict[str, None] = {}
        """Variables of the current expression that are None while no message has arrived."""
        self._expression: Sampled
        self.names: dict[str, Any] = {**FUNCTIONS, "_compared": compared, "_unordered": unordered}
        """Global names of the function."""

    def add(self, expression: Sampled) -> list[str]:
        """Add an expression; return the names of its result variables. The first one is None until all messages have arrived."""
        self._expression, self._arriving, before = expression, {}, self._lines
        self._lines = []
        results = expression.add_to(self)
        lines, self._lines = self._lines, before
        if not self._arriving:
            self._lines += lines
            return results
        kept = [self._name() for _ in results]
        missing = " or ".join(f"{name} is None" for name in self._arriving)
        lines.append(f"{', '.join(kept)} = {', '.join(results)}")
        self._lines += [f"if {missing}: {kept[0]} = None", "else:", *(f" {line}" for line in lines)]
        return kept

    def function(self, ending: Sequence[str], failed: str = "raise") -> Callable[..., Any]:
        """Return the function.

        Args:
            ending: statements that follow the computation of the samples.
            failed: statement that is executed if this computation raises an `error`.
        """
        body = ["pass", *self._reads, *self._lines]
        lines = [" try:", *(f"  {line}" for line in body), f" except Exception as error: {failed}"]
        source = "\n".join([f"def sampled({self._parameters}):", *lines, *(f" {line}" for line in ending)])
        names = {**self.names, "Exception": Exception, "__builtins__": {}}
        exec(_code(source), names)
        made: Callable[..., Any] = names["sampled"]
        return made

    def constant(self, value: object) -> str:
        """Return a name for a value in the generated function."""
        name = self._name()
        self.names[name] = value
        return name

    def sample(self, node: ast.expr) -> tuple[str, str]:
        """Add a condition, and return the names of the variables of its value and its margin."""
        match node:
            case ast.BoolOp():
                held, margins = zip(*map(self.sample, node.values), strict=True)
                word, limit = ("and", "min") if isinstance(node.op, ast.And) else ("or", "max")
                return self._let(f" {word} ".join(held)), self._let(f"{limit}({', '.join(margins)})")
            case ast.UnaryOp(op=ast.Not()):
                one, margin = self.sample(node.operand)
                return self._let(f"not {one}"), self._let(f"-{margin}")
            case ast.Compare(ops=[op]) if type(op) in _ORDERS and (
                sides := self._numbers(node.left, *node.comparators)
            ):
                symbol, order = _ORDERS[type(op)]
                low, high = map(self._let, sides[::order])
                one, margin = self._let(f"{low} {symbol} {high}"), self._let(f"{high} - {low}")
                self._lines.append(f"if {margin} != {margin}: {margin} = _unordered({low}, {high}, {one})")
                return one, margin
            case ast.Compare() if all(type(op) in COMPARISONS for op in node.ops):
                operators = self.constant([COMPARISONS[type(op)] for op in node.ops])
                values = ", ".join(map(self.value, (node.left, *node.comparators)))
                one, margin = self._name(), self._name()
                self._lines.append(f"{one}, {margin} = _compared({operators}, {values})")
                return one, margin
        one = self._let(f"bool({self.value(node)})")
        return one, self._let(f"inf if {one} else -inf")

    def value(self, node: ast.expr) -> str:
        """Add an operand, and return its variable: plain Python computes it if it consists of numbers, else the guard."""
        if text := self._plain(node)[1]:
            return self._let(text)
        code, names = compiled(node), dict(FUNCTIONS)
        used = [part.id for part in ast.walk(node) if isinstance(part, ast.Name) and part.id in self._expression.bound]

        def evaluate(*values: Any) -> Any:
            names.update(zip(used, values, strict=True))
            return FieldGuard().evaluate(code, names)

        readings = [self._variable(self._expression.bound[name][1], self._expression.bound[name][0]) for name in used]
        return self._let(f"{self.constant(evaluate)}({', '.join(readings)})")

    def _plain(self, node: ast.expr) -> tuple[Kind, str]:
        """Return the kind of a value and its plain Python text, which is empty if only the guard may compute the value."""
        match node:
            case ast.Constant(value=bool() | int() | float() as value):
                return "number", repr(value) if abs(value) < _LARGE else self.constant(value)
            case ast.Name(id=name) if name in _CONSTANTS:
                return "number", name
            case ast.Name() | ast.Attribute():
                return self._field(node)
            case ast.Subscript(slice=index) if (whole := _whole(index)) is not None:
                kind, text = self._plain(node.value)
                return ("number", f"{text}[{whole}]") if kind == "vector" else _OTHER
            case ast.UnaryOp(op=ast.USub() | ast.UAdd()) if numbers := self._numbers(node.operand):
                return "number", f"({_SIGNS[type(node.op)]}{numbers[0]})"
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(power))) if power <= MAX_EXPONENT:
                nested = any(isinstance(part, ast.Pow) for part in ast.walk(node.left))
                numbers = [] if nested else self._numbers(node.left)
                return ("number", f"(({numbers[0]} * 1.0) ** {power})") if numbers else _OTHER
            case ast.BinOp() if type(node.op) in _OPERATORS and (numbers := self._numbers(node.left, node.right)):
                return "number", f"({numbers[0]} {_OPERATORS[type(node.op)]} {numbers[1]})"
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _NUMERIC and (
                numbers := self._numbers(*node.args)
            ):
                return "number", f"{name}({', '.join(numbers)})"
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _COLLECTIVE:
                operands = [self._plain(argument) for argument in node.args]
                if all(kind in ("number", "vector") for kind, _ in operands):
                    return "number", f"{name}({', '.join(text for _, text in operands)})"
        return _OTHER

    def _numbers(self, *nodes: ast.expr) -> list[str]:
        """Return the plain Python texts of numbers; an empty list if one of the values is not a number."""
        operands = [self._plain(node) for node in nodes]
        return [text for _, text in operands] if all(kind == "number" for kind, _ in operands) else []

    def _field(self, node: ast.expr) -> tuple[Kind, str]:
        """Return the kind and the variable of a reading, or of a number or vector in a record."""
        path: list[str] = []
        while isinstance(node, ast.Attribute):
            path.insert(0, node.attr)
            node = node.value
        if not isinstance(node, ast.Name) or node.id not in self._expression.bound:
            return _OTHER
        text, reading = self._expression.bound[node.id]
        found = reading.field(".".join(path)) if path else reading
        if found is None:
            return _OTHER
        return found.kind, self._variable(found, ".".join([text, *path]))

    def _variable(self, reading: Reading, text: str) -> str:
        """Return the variable of a reading, which all conditions share unless `reading.arrives`."""
        key = text, id(self._expression) if reading.arrives else None
        for name, read in reading.of:
            self._read(name, read)
        variable = self._read(key, reading.read, *(self._variables[name] for name, _ in reading.of))
        if reading.arrives:
            self._arriving[variable] = None
        return variable

    def _read(self, key: object, read: Callable[..., Any], *arguments: str) -> str:
        """Return the variable of a value; at the first call, add the statement that reads it."""
        if key not in self._variables:
            self._variables[key] = self._name()
            self._reads.append(f"{self._variables[key]} = {self.constant(read)}({', '.join(arguments)})")
        return self._variables[key]

    def _name(self) -> str:
        name = f"_{len(self.names)}"
        self.names[name] = None
        return name

    def _let(self, text: str) -> str:
        """Return a name or a constant unchanged; assign any other value to a variable, and return its name."""
        if text.isidentifier() or text.replace(".", "").isdigit():
            return text
        name = self._name()
        self._lines.append(f"{name} = {text}")
        return name


@lru_cache(maxsize=256)
def _code(source: str) -> Any:
    return compile(source, "<expectations>", "exec")


def _whole(index: ast.expr) -> int | None:
    """Return the value of a constant index; None if the index is not a constant integer."""
    try:
        value = ast.literal_eval(index)
    except ValueError:
        return None
    return value if type(value) is int else None
