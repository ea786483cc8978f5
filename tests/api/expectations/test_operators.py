"""Each operator, compared with its definition over a whole list of samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.api.expectations.operators import Always, Count, Holds, Operator, Sample, Until, Verdict, Within

STEP = 1 / 60  # s
Samples = list[Sample]
margins = st.lists(st.integers(-3, 3), min_size=1, max_size=30)
steps = st.integers(0, 12)
Naive = Callable[[Samples, Sequence[float]], tuple[bool, float]]


def samples_of(numbers: Sequence[int], strict: bool) -> Samples:
    return [Sample(number > 0 if strict else number >= 0, float(number)) for number in numbers]


def judged(operator: Operator, *signals: Samples) -> Verdict:
    for number, samples in enumerate(zip(*signals, strict=True)):
        operator.add(number * STEP, *itertools.chain(*samples))
    operator.end()
    return operator.verdict


def check(verdict: Verdict, met: bool, robustness: float) -> None:
    assert verdict.outcome == ("passed" if met else "failed")
    assert verdict.robustness == pytest.approx(robustness)
    assert verdict.decided is not None


@given(margins, st.booleans(), steps)
def test_always_is_a_conjunction_over_the_samples_from_a_time_on(numbers: list[int], strict: bool, after: int) -> None:
    samples = samples_of(numbers, strict)
    counted = samples[after:] or samples[-1:]
    check(judged(Always(after * STEP), samples), all(s.holds for s in counted), min(s.margin for s in counted))


@given(margins, st.booleans(), steps)
def test_within_is_a_disjunction_over_the_samples_up_to_a_time(numbers: list[int], strict: bool, last: int) -> None:
    samples = samples_of(numbers, strict)
    counted = samples[: last + 1]
    check(judged(Within(last * STEP), samples), any(s.holds for s in counted), max(s.margin for s in counted))


@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=1, max_size=30), st.booleans())
def test_until_needs_the_second_condition_and_the_first_one_before_it(
    numbers: list[tuple[int, int]], strict: bool
) -> None:
    first, second = (samples_of(column, strict) for column in zip(*numbers, strict=True))
    met = any(second[n].holds and all(s.holds for s in first[:n]) for n in range(len(numbers)))
    robustness = max(min([second[n].margin, *(s.margin for s in first[:n])]) for n in range(len(numbers)))
    check(judged(Until(), first, second), met, robustness)


@given(margins, steps)
def test_holds_finds_the_longest_uninterrupted_time(numbers: list[int], length: int) -> None:
    samples = samples_of(numbers, strict=True)
    runs = [len(list(group)) - 1 for holds, group in itertools.groupby(s.holds for s in samples) if holds]
    met = any(run >= length for run in runs)
    check(judged(Holds(length * STEP), samples), met, (max(runs, default=0) - length) * STEP)


@given(margins, st.integers(0, 4), st.one_of(st.integers(0, 4), st.just(math.inf)))
def test_count_counts_how_often_the_condition_becomes_true(numbers: list[int], low: int, high: float) -> None:
    samples = samples_of(numbers, strict=True)
    number = sum(holds for holds, _ in itertools.groupby(s.holds for s in samples))
    check(judged(Count(low, high), samples), low <= number <= high, min(number - low, high - number))


@given(margins)
def test_the_operator_never_equals_always_of_the_opposite_condition(numbers: list[int]) -> None:
    samples = [Sample(not held, -margin) for held, margin in samples_of(numbers, strict=False)]
    check(judged(Always(), samples), all(number < 0 for number in numbers), min(-number for number in numbers))


def test_a_verdict_is_decided_at_the_first_sample_that_decides_it_and_its_robustness_covers_the_whole_run() -> None:
    operator = Always()
    assert not operator.add(0.0, True, 2.0)
    assert operator.verdict == Verdict("open", None, 2.0, 0.0)
    assert operator.add(1.0, False, -1.0)
    assert operator.verdict == Verdict("failed", 1.0, -1.0, 1.0)
    assert not operator.add(2.0, False, -3.0)
    assert not operator.add(3.0, True, 5.0)
    operator.end()
    assert operator.verdict == Verdict("failed", 1.0, -3.0, 2.0)


@pytest.mark.parametrize("operator", [Within(1.0), Until(), Holds(1.0)])
def test_a_run_that_ends_early_does_not_meet_an_undecided_expectation(operator: Operator) -> None:
    operator.add(0.0, False, -1.0)
    assert operator.verdict.outcome in ("open", "failed")
    operator.end()
    assert operator.verdict.outcome == "failed"
