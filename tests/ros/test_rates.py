"""Rates and delays as ros2cli counts them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.ros.rates import SECOND, Intervals, Summary

MILLISECOND = 1_000_000


def test_an_empty_window_has_no_summary() -> None:
    assert Summary.of([]) is None
    assert Intervals(10).report() is None


@given(st.lists(st.integers(-(10**12), 10**12), min_size=1, max_size=40))
def test_a_summary_covers_all_values(values: list[int]) -> None:
    summary = Summary.of(values)
    assert summary is not None
    mean = sum(values) / len(values)
    variance = sum((value - mean) ** 2 for value in values) / len(values)
    assert (summary.least, summary.most, summary.number) == (min(values), max(values), len(values))
    assert summary.mean == pytest.approx(mean)
    assert summary.deviation == pytest.approx(math.sqrt(variance), abs=1e-3)


def test_a_summary_has_the_text_of_ros2cli() -> None:
    summary = Summary.of([12 * MILLISECOND, 22 * MILLISECOND])
    assert str(summary) == "\tmin: 0.012s max: 0.022s std dev: 0.00500s window: 2"


def test_intervals_are_reported_once_a_second() -> None:
    intervals = Intervals(1000)
    told = []
    for tick in range(241):
        assert intervals.add(tick * SECOND // 60)
        if summary := intervals.report():
            told.append((tick, summary.number, round(SECOND / summary.mean, 3)))
    assert told == [(61, 61, 60.0), (121, 121, 60.0), (181, 181, 60.0)]


def test_statistics_cover_the_newest_intervals() -> None:
    intervals = Intervals(2)
    for now in (0, 5 * SECOND, 6 * SECOND, 8 * SECOND):
        intervals.add(now)
    summary = intervals.report()
    assert summary is not None
    assert (summary.least, summary.most, summary.number) == (SECOND, 2 * SECOND, 2)


def test_a_clock_that_jumps_back_restarts_the_measurement() -> None:
    intervals = Intervals(1000)
    for tick in range(100):
        intervals.add(tick * SECOND // 60)
    assert not intervals.add(0)
    assert intervals.report() is None
    assert intervals.add(SECOND)
    assert intervals.add(3 * SECOND)
    summary = intervals.report()
    assert summary is not None
    assert (summary.least, summary.most, summary.number) == (SECOND, 2 * SECOND, 2)
