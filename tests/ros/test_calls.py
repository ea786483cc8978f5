"""Calls by number: each is answered once at most, and what is never answered is not kept for ever."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from graphengine.ros.transports.calls import MAX_OPEN, Calls


@given(st.lists(st.integers(-1, 8)))
def test_each_call_ends_once(answers: list[int]) -> None:
    calls = Calls()
    assert [calls.begin() for _ in range(6)] == [1, 2, 3, 4, 5, 6]
    ended = [number for number in answers if calls.end(number)]
    assert ended == [number for number in dict.fromkeys(answers) if 1 <= number <= 6]


def test_the_oldest_call_is_given_up_where_too_many_wait() -> None:
    calls = Calls()
    for _ in range(MAX_OPEN + 2):
        last = calls.begin()
    assert [calls.end(number) for number in (1, 2, 3, last)] == [None, None, True, True]
