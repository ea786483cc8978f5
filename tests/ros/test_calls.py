"""Calls by number: each is answered once at most, and what is never answered is not kept for ever."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.ros.service_caller import ServiceCaller
from graphengine.ros.transports.calls import MAX_OPEN, Calls
from graphengine.ros.transports.memory.memory import MemoryTransport


@given(st.lists(st.integers(-1, 8)))
def test_each_call_ends_once(answers: list[int]) -> None:
    calls = Calls()
    assert [calls.begin() for _ in range(6)] == [1, 2, 3, 4, 5, 6]
    ended = [number for number in answers if calls.end(number)]
    assert ended == [number for number in dict.fromkeys(answers) if 1 <= number <= 6]


def test_with_too_many_open_calls_the_oldest_is_discarded() -> None:
    calls = Calls()
    for _ in range(MAX_OPEN + 2):
        last = calls.begin()
    assert [calls.end(number) for number in (1, 2, 3, last)] == [None, None, True, True]


def test_with_too_many_unanswered_calls_the_oldest_fails() -> None:
    caller = ServiceCaller(MemoryTransport(), "/light", "std_srvs/srv/Trigger")
    request = DEFINITIONS.initial("std_srvs/srv/Trigger_Request")
    first, second, *_ = [caller.call(request) for _ in range(MAX_OPEN + 1)]
    with pytest.raises(TransportError, match="/light: no response"):
        first.result(0)
    assert not second.done()
