"""Answers of confined processes: what they may hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from graphengine.sandbox.untrusted import read


@dataclass
class Answer:
    value: Any


@pytest.mark.parametrize(("number", "kind"), [(-(2**63) - 1, float), (-(2**63), int), (2**64 - 1, int), (2**64, float)])
def test_a_whole_number_of_more_than_64_bits_becomes_a_float(number: int, kind: type[float]) -> None:
    value = read(b'{"value": %d}' % number, Answer, 100).value
    assert (type(value), value) == (kind, kind(number))
