"""Numbers with units on the command line."""

from __future__ import annotations

import argparse
import math

import pytest

from graphengine.cli.quantities import address, angle


@pytest.mark.parametrize("text", ["1.5", "1.5rad", f"{math.degrees(1.5)!r}deg", " 1.5 "])
def test_an_angle_is_in_radians_without_the_unit_deg(text: str) -> None:
    assert angle(text) == pytest.approx(1.5, rel=1e-15)


@pytest.mark.parametrize("text", ["", "deg", "1.5 turns", "e", "1.5degrees"])
def test_an_illegal_angle_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        angle(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("8765", ("127.0.0.1", 8765)),
        ("0.0.0.0:0", ("0.0.0.0", 0)),
        ("lab-pc:9000", ("lab-pc", 9000)),
        (" [::1]:65535 ", ("::1", 65535)),
    ],
)
def test_an_address_without_a_host_is_this_machine(text: str, expected: tuple[str, int]) -> None:
    assert address(text) == expected
