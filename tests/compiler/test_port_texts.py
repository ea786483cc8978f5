"""Values of ports as users read them."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from graphengine.compiler.port_texts import listed


def digits(number: float) -> int:
    """The significant decimal digits of a number's text."""
    return len(Decimal(repr(number)).normalize().as_tuple().digits)


@example([999999995904.0])
@given(st.lists(st.floats(width=32, allow_nan=False)))
def test_a_float_is_printed_by_the_shortest_decimal_that_reads_back_as_the_same(numbers: list[float]) -> None:
    values = np.array(numbers, np.float32)
    printed = listed(values)
    assert np.array(printed, np.float32).tolist() == values.tolist()
    assert all(digits(one) <= digits(float(other)) for one, other in zip(printed, values, strict=True))


def test_every_half_is_printed_by_a_decimal_that_reads_back_as_the_same() -> None:
    halves = np.arange(2**16, dtype=np.uint16).view(np.float16)
    assert np.array_equal(np.array(listed(halves), np.float16), halves, equal_nan=True)


def test_other_values_are_printed_as_they_are() -> None:
    assert listed(np.array([0.1 + 0.2])) == [0.1 + 0.2]
    assert listed(np.float32(0.45)) == 0.45
    assert listed(np.array([[1, 2], [3, 4]])) == [[1, 2], [3, 4]]
    assert listed(("a", 1.5)) == ("a", 1.5)
