"""Conditions: expressions over readings of a session, such as `tilt("dd100") < 0.1`, evaluated to samples with a margin."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np

from graphengine.api.expectations.operators import Sample
from graphengine.api.expectations.reading_types import Reading, Readings
from graphengine.api.expectations.sampling_code import SamplingCode
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.wording import printable, shown
from graphengine.sandbox.expressions import FUNCTIONS, ForbiddenError, compiled


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

    Attributes:
        tree: syntax tree, in which a name replaces each reading.
        bound: readings and their texts, by the names that replace them.
        arrives: whether the expression has no value before the messages of a topic arrive.
        states: states of the readings that have one.

    Raises:
        UsageError: the text is not a legal expression, or a reading refuses its arguments.
    """

    def __init__(self, text: str, readings: Readings) -> None:
        self.text = text
        binder = _Binder(readings)
        try:
            self.tree: ast.expr = binder.visit(parse(text, readings))
        except ValueError as error:
            raise UsageError(f"{printable(text)}: {error}") from None
        self.bound = binder.bound
        self.arrives = any(reading.arrives for _, reading in self.bound.values())
        self.states = [reading.state for _, reading in self.bound.values() if reading.state is not None]

    def add_to(self, code: SamplingCode) -> list[str]:
        """Add the computation of the value to generated code, and return the name of its variable."""
        return [code.value(self.tree)]

    @cached_property
    def _evaluate(self) -> Callable[[], Any]:
        code = SamplingCode()
        first, *others = code.add(self)
        return code.function([f"return {first} if {first} is None else ({', '.join([first, *others])})"])

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
        except GraphError:
            raise
        except Exception as error:  # functions and operators fail in many ways on unexpected values
            raise UsageError(f"{printable(self.text)}: {error}") from None

    def values(self) -> dict[str, Any]:
        """Return the current value of each reading that has one, by the text of the reading in the expression."""
        found = {text: reading.value for text, reading in self.bound.values()}
        return {text: value for text, value in found.items() if value is not None}


class Condition(Expression):
    """An expression whose value is true or false, with a margin.

    The margin of a comparison of numbers is the difference of its sides; of an equality, the negative absolute difference.
    `and` has the smallest margin of its parts, `or` the largest one, and `not` the negated one. All other values have an infinite
    margin. All parts are evaluated in every tick, so the condition has no value while one of its readings has none.

    >>> Condition("1 < limit() and limit() <= 4", {"limit": lambda: Reading(lambda: 3.0)}).sample()
    Sample(holds=True, margin=1.0)
    """

    def add_to(self, code: SamplingCode) -> list[str]:
        """Add the computation of a sample to generated code, and return the names of the variables of its value and margin."""
        return list(code.sample(self.tree))

    def sample(self) -> Sample | None:
        """Return the current value with its margin; None while a reading has no value.

        Raises:
            UsageError: the evaluation failed, for example because of a division by zero.
        """
        sample = self._read()
        return None if sample is None else Sample(bool(sample[0]), float(sample[1]))


class _Binder(ast.NodeTransformer):
    """Replaces each distinct reading in a syntax tree with a unique name."""

    def __init__(self, readings: Readings) -> None:
        self._readings = readings
        self._names: dict[str, str] = {}
        """The names that replace the readings, by the text of each reading."""
        self.bound: dict[str, tuple[str, Reading]] = {}
        """The texts and readings, by the names that replace them."""

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
        if text not in self._names:
            try:
                reading = self._readings[function](*arguments, **named)
            except GraphError:
                raise
            except Exception as error:  # wrong number or types of arguments
                raise ValueError(str(error).replace(f"{function}()", function)) from None
            self._names[text] = f"reading_{len(self.bound)}"
            self.bound[self._names[text]] = text, reading
        return ast.copy_location(ast.Name(self._names[text], ast.Load()), node)
