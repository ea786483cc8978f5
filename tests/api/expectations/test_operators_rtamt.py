"""The operators against rtamt, an independent implementation of signal temporal logic, on random signals.

rtamt is no dependency, and has no release for Python 3.13: `pip install rtamt` in an environment with Python 3.11 or 3.12, then
`pytest tests/api/expectations/test_operators_rtamt.py`. Without rtamt, the tests are skipped.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from graphengine.api.expectations.operators import Always, Holds, Operator, Until, Verdict, Within

rtamt: Any = pytest.importorskip("rtamt")
SIGNALS, LONGEST, STEP = 200, 40, 0.05  # s

Signal = Sequence[float]
Case = tuple[str, Operator]
"""A formula over the signals a and b, and the operator that judges the same."""


def always(last: int, draw: random.Random) -> Case:
    return f"always[0:{last}](a >= 0)", Always()


def settles(last: int, draw: random.Random) -> Case:
    after = draw.randint(0, last)
    return f"always[{after}:{last}](a >= 0)", Always(after * STEP)


def within(last: int, draw: random.Random) -> Case:
    end = draw.randint(0, last)
    return f"eventually[0:{end}](a >= 0)", Within(end * STEP)


def until(last: int, draw: random.Random) -> Case:
    return f"(a >= 0) until[0:{last}] (b >= 0)", Until()


def holds(last: int, draw: random.Random) -> Case:
    length = draw.randint(0, last)
    return f"eventually[0:{last - length}](always[0:{length}](a >= 0))", Holds(length * STEP)


def signal(length: int, draw: random.Random) -> Signal:
    """A random walk, or noise."""
    level, steps = 0.0, draw.choice([0.0, 1.0])
    values = []
    for _ in range(length):
        level = steps * level + draw.uniform(-1.0, 1.0)
        values.append(level + draw.choice([0.0, 0.5]))
    return values


def robustness(formula: str, **signals: Signal) -> float:
    specification = rtamt.StlDiscreteTimeSpecification()
    for name in (*signals, "out"):
        specification.declare_var(name, "float")
    specification.spec = f"out = {formula}"
    specification.parse()
    times = list(range(len(next(iter(signals.values())))))
    return float(specification.evaluate({"time": times, **signals})[0][1])


def judged(operator: Operator, *signals: Signal) -> Verdict:
    for number, values in enumerate(zip(*signals, strict=True)):
        operator.add(number * STEP, *(part for value in values for part in (value >= 0.0, value)))
    operator.end()
    return operator.verdict


@pytest.mark.parametrize("kind", [always, settles, within, until, holds])
def test_verdict_and_robustness_equal_the_results_of_rtamt(kind: Callable[[int, random.Random], Case]) -> None:
    draw = random.Random(kind.__name__)
    outcomes = set()
    for _ in range(SIGNALS):
        length = draw.randint(2, LONGEST)  # rtamt needs two samples
        first, second = signal(length, draw), signal(length, draw)
        formula, operator = kind(length - 1, draw)
        expected = robustness(formula, a=first, b=second)
        verdict = judged(operator, first, second) if kind is until else judged(operator, first)
        assert verdict.outcome == ("passed" if expected >= 0.0 else "failed"), (formula, first, second)
        if kind is not holds:  # its robustness is a time
            assert verdict.robustness == pytest.approx(expected), (formula, first, second)
        outcomes.add(verdict.outcome)
    assert outcomes == {"passed", "failed"}
