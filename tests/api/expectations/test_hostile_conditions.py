"""Hostile conditions: they execute no code, read only readings, and end soon."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from graphengine.api.expectations.conditions import Condition
from graphengine.api.expectations.operators import Sample
from graphengine.api.expectations.reading_types import Reading
from graphengine.format.errors import UsageError
from graphengine.messages.definitions import DEFINITIONS

MUTATIONS = 200
LONG = 30_000
POWER = f"(9{'9' * 4000})**16"
SCAN = DEFINITIONS.initial("sensor_msgs/msg/LaserScan")
SCAN.ranges = np.linspace(0.0, 1.0, LONG, dtype=np.float32)
READINGS: dict[str, Callable[..., Reading]] = {
    "x": lambda: Reading(lambda: 3.0),
    "time": lambda: Reading(lambda: 2.0),
    "large": lambda: Reading(lambda: 10**18),
    "word": lambda: Reading(lambda: "ready" * 1000, "other"),
    "port": lambda address: Reading(lambda: np.arange(float(LONG)), "vector"),
    "cloud": lambda topic: Reading(lambda: np.ones((LONG, 3)), "other"),
    "message": lambda topic: Reading(lambda: SCAN, "other"),
    "contact": lambda body, other="*": Reading(lambda: True),
}


def sample(text: str) -> Sample | None:
    condition = Condition(text, READINGS)
    condition.values()
    return condition.sample()


@pytest.mark.timeout(30)
@pytest.mark.parametrize(
    ("text", "message"),
    [
        # code
        ("().__class__.__bases__[0].__subclasses__()", "not allowed"),
        ("message('a').__init__.__globals__", "not allowed"),
        ("'{0.__class__}'.format(x)", "the attribute 'format'"),
        ("word.format_map(x)", "the attribute 'format_map'"),
        ("port('a').tofile('written')", "the attribute 'tofile'"),
        ("__import__('os')", "not allowed"),
        ("open('/etc/passwd')", "there is no name 'open'"),
        ("getattr(x, 'real')", "there is no name 'getattr'"),
        ("reading_0 < 1", "there is no name 'reading_0'"),
        ("(lambda: 0)()", "not allowed"),
        ("[x := 3]", "not allowed"),
        ("port(contact)", "must be constants"),
        # time and memory
        ("9**9**9 > 1", "more than 10000 bits"),
        ("round(5, -10**9) > 1", "rounding to more than 10000 digits"),
        ("round(5, ndigits=-10**9) > 1", "rounding to more than 10000 digits"),
        ("'a' * 10**10 == word", "at most 1000000 steps"),
        ("'%1000000000d' % 5 == word", "more than 999 characters"),
        ("f'{x:>1000000000}' == word", "more than 999 characters"),
        ("[a for a in word for b in word for c in word] == x", "at most 1000000 steps"),
        ("max([[a] * 1000 for a in [0] * 1000]) > x", "at most 1000000 steps"),
        ("port('a')[:, None] * port('a') > x", "several dimensions"),
        ("(port('a')[:, None] < port('a'))[0][0]", "several dimensions"),
        ("sum([port('a')[:, None], port('a')]) > x", "several dimensions"),
        ("message('a').ranges[:, None] @ message('a').ranges[None] > x", "several dimensions"),
        ("cloud('a')[:, :1] < cloud('a')[:, 0]", "several dimensions"),
        ("*".join([POWER] * 20) + " > x", "int too large to convert to float"),
        ("(" * 5000 + "x" + ")" * 5000, ""),
        ("x < " + "x" * 200_000, "at most 100000 characters"),
        ("x and " * 3000 + "x < y", "there is no name 'y'"),
        ("x\0 < 5", ""),
    ],
)
def test_a_hostile_condition_is_refused(text: str, message: str) -> None:
    with pytest.raises(UsageError) as refused:
        sample(text)
    assert message in str(refused.value)


@pytest.mark.parametrize(
    "text", ["cloud('a')[0][1] == 1", "cloud('a')[5, 2] == 1", "max(cloud('a')[:, 0]) == 1", "large ** 4 > x"]
)
def test_an_index_for_each_dimension_is_legal(text: str) -> None:
    found = sample(text)
    assert found is not None
    assert found.holds


VALID = (
    "1 < x <= 3.5 and time > 1",
    "message('a').angle_min ** 2 < 10",
    "sum([v for v in port('a')[:9] if v > 1]) > 3.5",
    "word in ('ready', 'done')",
    "not contact('dd100', '/World/racks/*')",
    "f'{x:.2f}' == '3.00'",
    "max(cloud('a')[0]) - min(port('a')) == 3",
)
PIECES = (
    *(
        "(",
        ")",
        "[",
        "]",
        "{",
        "}",
        "**",
        "*",
        "@",
        "<<",
        "~",
        "<",
        "==",
        ",",
        ":",
        ":=",
        "'",
        "f'{",
        "\n",
        "\0",
        "\\",
        "é",
        "%",
    ),
    *(
        " not ",
        " lambda ",
        " for a in ",
        " if ",
        " else ",
        "x",
        "port('a')",
        "cloud('a')",
        "message('a')",
        "word",
        "[:, None]",
    ),
    *(".__class__", ".format", "999999999", "-1", "0.5", "None", "round", "sum", "str"),
)


def mutated(text: str, draw: random.Random) -> str:
    for _ in range(draw.randint(1, 4)):
        begin = draw.randint(0, len(text))
        end = begin + draw.choice([0, 0, 1, 4])
        text = text[:begin] + draw.choice(PIECES) + text[end:]
    return text


@pytest.mark.timeout(120)
def test_each_mutation_is_legal_or_refused() -> None:
    draw = random.Random(35)
    outcomes: dict[Any, int] = {}
    for _ in range(MUTATIONS):
        text = mutated(draw.choice(VALID), draw)
        try:
            outcome = type(sample(text))
        except UsageError:
            outcome = UsageError  # type: ignore[assignment]
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
    assert {*outcomes} == {Sample, UsageError}
    assert outcomes[UsageError] > MUTATIONS / 2
