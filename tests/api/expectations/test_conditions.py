"""Conditions: values, margins and errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from graphengine.api.expectations.conditions import Condition
from graphengine.api.expectations.operators import Sample
from graphengine.api.expectations.reading_types import Reading
from graphengine.format.errors import UsageError
from graphengine.messages import messages

INF = math.inf


@dataclass
class Pose:
    position: tuple[float, float, float]
    _secret: int = 0


POSITION = {"position": Reading(lambda: (1.0, 2.0, 3.0), "vector")}
READINGS: dict[str, Callable[..., Reading]] = {
    "x": lambda: Reading(lambda: 3.0),
    "time": lambda: Reading(lambda: 2.0),
    "touches": lambda name, other="": Reading(lambda: (name, other) == ("dd100", "wall")),
    "pose": lambda name: Reading(
        lambda: Pose((1.0, 2.0, 3.0)), "other", {"position": Reading(lambda: (1.0, 2.0, 3.0), "vector")}.get
    ),
    "port": lambda address: Reading(lambda: np.array([1.0, 4.0]), "vector"),
    "message": lambda topic: Reading(lambda: messages.Vector3(1.0, 2.0, INF), "other"),
    "word": lambda: Reading(lambda: "ready", "other"),
    "absent": lambda: Reading(lambda: None, arrives=True),
}


def sample(text: str) -> Sample | None:
    return Condition(text, READINGS).sample()


@pytest.mark.parametrize(
    ("text", "holds", "margin"),
    [
        ("x() < 5", True, 2.0),
        ("x < 3", False, 0.0),
        ("x <= 3", True, 0.0),
        ("time > 0.5", True, 1.5),
        ("1 < x <= 3.5", True, 0.5),
        ("1 < x < 3 < 9", False, 0.0),
        ("4 < x <= 3.5", False, -1.0),
        ("x == 3", True, 0.0),
        ("x == 5", False, -2.0),
        ("x != 5", True, 2.0),
        ("x > 5 or time > 1", True, 1.0),
        ("x > 5 and time > 1", False, -2.0),
        ("not x > 5", True, 2.0),
        ("not (x > 5 or time > 1)", False, -1.0),
        ("touches('dd100', 'wall')", True, INF),
        ("not touches('dd100', 'floor')", True, INF),
        ("touches('dd100', 'wall') and x < 5", True, 2.0),
        ("pose('dd100').position[1] >= 1.5", True, 0.5),
        ("abs(pose('dd100').position[-1] - x) < 0.1", True, 0.1),
        ("hypot(port('a')[0], port('a')[1]) < 5", True, 5 - math.sqrt(17)),
        ("max(port('a')) - min(port('a')) == 3", True, 0.0),
        ("sum([v for v in port('a') if v > 1]) > 3.5", True, 0.5),
        ("message('scan').x < 4", True, 3.0),
        ("message('scan').z > 4", True, INF),
        ("message('scan').z < message('scan').z", False, -INF),
        ("word == 'ready'", True, INF),
        ("word in ('ready', 'done')", True, INF),
        ("word.startswith('x')", False, -INF),
        ("x ** 2 < 10", True, 1.0),
        ("x if time > 1 else 0", True, INF),
    ],
)
def test_a_condition_has_a_value_and_a_margin(text: str, holds: bool, margin: float) -> None:
    found = sample(text)
    assert found is not None
    assert found.holds is holds
    assert found.margin == pytest.approx(margin)


def test_a_condition_without_a_value_yet_has_no_sample() -> None:
    assert sample("x < 5 and absent() > 2") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x <", "not an expression: invalid syntax\n  x <\n     ^"),
        ("((9 ** 16) ** 16) ** 16 > 0", "a number of more than 10000 bits"),
        ("y < 3", "there is no name 'y'"),
        ("tiem < 3", "did you mean 'time'?"),
        ("touches()", "missing 1 required positional argument: 'name'"),
        ("pose(word)", "the arguments of pose must be constants"),
        ("().__class__", "not allowed"),
        ("lambda: 0", "Lambda is not allowed"),
        ("9 ** 9 ** 9 > x", "a number of more than 10000 bits"),
        ("1 / (x - 3) > 0", "division by zero"),
        ("pose('a')._secret > 0", "the attribute '_secret'"),
        ("message('scan').w > 0", "the attribute 'w'"),
        ("port('a')[7] > 0", "out of bounds"),
        ("port('a') * 1000000000 == 0", "ambiguous"),
        ("[0] * 1000000000 == word", "at most 1000000 steps"),
        ("x[0] > 1", "not subscriptable"),
    ],
)
def test_an_illegal_condition_is_refused_with_the_reason(text: str, message: str) -> None:
    with pytest.raises(UsageError) as refused:
        sample(text)
    assert message in str(refused.value)


NUMBERS = st.floats(-10, 10) | st.integers(-10, 10)
OPERANDS = st.recursive(
    st.one_of(NUMBERS.map(lambda number: f"({number})"), st.just("x")),
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from("+-*"), part).map(lambda each: f"({''.join(each)})"), part.map("-{}".format)
    ),
    max_leaves=6,
)
COMPARISONS = st.tuples(OPERANDS, st.sampled_from(["<", "<=", ">", ">="]), OPERANDS).map(" ".join)
CONDITIONS = st.recursive(
    COMPARISONS,
    lambda part: st.one_of(
        st.tuples(part, st.sampled_from(["and", "or"]), part).map(lambda each: f"({' '.join(each)})"),
        part.map("(not {})".format),
    ),
    max_leaves=5,
)


@given(CONDITIONS)
def test_the_value_of_a_condition_agrees_with_python_and_with_the_sign_of_its_margin(text: str) -> None:
    found = sample(text)
    assert found is not None
    assert found.holds is bool(eval(text, {"x": 3.0}))
    assume(found.margin)
    assert found.holds is (found.margin > 0)
