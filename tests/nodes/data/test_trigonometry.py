"""Sines and their like, and degrees and radians."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.data import trigonometry
from graphengine.nodes.data.trigonometry import ATan2, ToDeg, ToRad
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player

TRIGONOMETRY = [
    ("Sin", 30.0, 0.5),
    ("Cos", 60.0, 0.5),
    ("Tan", 45.0, 1.0),
    ("Asin", 0.5, 30.0),
    ("Acos", 0.5, 60.0),
    ("Atan", 1.0, 45.0),
]


@pytest.mark.parametrize(("name", "value", "expected"), TRIGONOMETRY)
def test_angles_are_in_degrees(play: Player, name: str, value: float, expected: float) -> None:
    cls = getattr(trigonometry, name)
    assert computed(cls, value_in=value).value_out == pytest.approx(expected, abs=1e-13)
    many = typed(cls, {"value_in": "float[2][]"}, value_in=np.full((2, 2), value, np.float32)).value_out
    assert many.dtype == np.float32
    np.testing.assert_allclose(many, np.full((2, 2), expected), rtol=1e-6)
    shows = shown(play, "double Here.value", {"Here": f"{{type: {name}, inputs: {{value: {value}}}}}"})
    assert shows == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("name", ["Asin", "Acos"])
def test_arc_sine_and_arc_cosine_of_numbers_above_1_are_nan(name: str) -> None:
    assert math.isnan(computed(getattr(trigonometry, name), value_in=1.5).value_out)


@given(st.floats(-179.9, 179.9), st.floats(0.1, 10.0))
def test_atan2_is_the_angle_of_a_point_from_the_x_axis(angle: float, radius: float) -> None:
    y, x = radius * math.sin(math.radians(angle)), radius * math.cos(math.radians(angle))
    assert computed(ATan2, a=y, b=x).result == pytest.approx(angle, abs=1e-9)
    assert computed(ATan2, a=(y, 1.0), b=(x, 0.0)).result == pytest.approx((angle, 90.0), abs=1e-9)


@given(st.floats(-1e3, 1e3))
def test_converting_to_radians_and_back_gives_the_same_angle(angle: float) -> None:
    radians = computed(ToRad, degrees=angle).radians
    assert radians == pytest.approx(angle * math.pi / 180.0, rel=1e-15)
    assert computed(ToDeg, radians=radians).degrees == pytest.approx(angle, rel=1e-14)


def test_degrees_of_an_array_are_an_array() -> None:
    assert computed(ToRad, degrees=np.array([0.0, 180.0])).radians.tolist() == [0.0, math.pi]


def test_in_a_graph_a_whole_literal_may_be_an_angle(play: Player) -> None:
    assert shown(play, "double Sine.value", {"Sine": "{type: Sin, inputs: {value: 90}}"}) == 1.0
