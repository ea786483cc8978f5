"""InterpolateTo, Ease and Interpolator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.nodes.data.interpolation import Ease, InterpolateTo, Interpolator
from graphengine.testing import RecordingContext
from tests.nodes.data.harness import computed, shown, typed
from tests.nodes.harness import Player, ready, yaw

FUNCTIONS = ["EaseIn", "EaseOut", "EaseInOut", "Linear", "SinIn", "SinOut", "SinInOut"]


@pytest.mark.parametrize(
    ("delta", "exponent", "way"), [(0.0, 2.0, 0.0), (0.25, 1.0, 0.5), (0.25, 2.0, 0.75), (1.0, 2.0, 1.0)]
)
def test_a_step_covers_its_share_of_the_way(delta: float, exponent: float, way: float) -> None:
    how = {"speed": 2.0, "delta_seconds": delta, "exponent": exponent}
    assert computed(InterpolateTo, current=10.0, target=20.0, **how).result == 10.0 + way * 10.0
    assert computed(InterpolateTo, current=(0.0, 4.0), target=(4.0, 0.0), **how).result == (way * 4.0, 4.0 - way * 4.0)


@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), st.floats(0.0, 5.0), st.floats(0.0, 3.0))
def test_a_step_never_goes_beyond_its_target(current: float, target: float, speed: float, delta: float) -> None:
    result = computed(InterpolateTo, current=current, target=target, speed=speed, delta_seconds=delta).result
    low, high = sorted((current, target))
    assert low - 1e-12 <= result <= high + 1e-12


def test_quaternions_go_along_the_shorter_arc() -> None:
    quaternions = {"current": "quatd[4]", "target": "quatd[4]"}
    start, end = yaw(0.0), yaw(1.0)
    how = {"speed": 1.0, "delta_seconds": 0.25, "exponent": 1.0}
    for target in (end, tuple(-part for part in end)):  # one rotation
        result = typed(InterpolateTo, quaternions, current=start, target=target, **how).result
        assert result == pytest.approx(yaw(0.25), abs=1e-12)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_easing_begins_at_the_start_ends_at_the_end_and_never_turns_back(name: str) -> None:
    how = {"start": 2.0, "end": 6.0, "ease_func": name, "blend_exponent": 3}
    assert computed(Ease, alpha=0.0, **how).result == pytest.approx(2.0, abs=1e-12)
    assert computed(Ease, alpha=1.0, **how).result == pytest.approx(6.0, abs=1e-12)
    assert computed(Ease, alpha=-1.0, **how).result == computed(Ease, alpha=0.0, **how).result
    steps = computed(Ease, alpha=np.linspace(0.0, 1.0, 21, dtype=np.float32), **how).result
    assert np.all(np.diff(steps) > 0.0)


EASED = [
    ("Linear", 0.25, 0.25),
    ("EaseIn", 0.5, 0.25),
    ("EaseOut", 0.5, 0.75),
    ("EaseInOut", 0.25, 0.125),
    ("EaseInOut", 0.75, 0.875),
    ("SinIn", 0.5, 1.0 - math.sqrt(0.5)),
    ("SinOut", 0.5, math.sqrt(0.5)),
    ("SinInOut", 0.5, 0.5),
]


@pytest.mark.parametrize(("name", "alpha", "expected"), EASED)
def test_an_easing_has_the_curve_of_its_name(name: str, alpha: float, expected: float) -> None:
    assert computed(Ease, alpha=alpha, start=0.0, end=1.0, ease_func=name).result == pytest.approx(expected, abs=1e-12)
    both = computed(Ease, alpha=alpha, start=(0.0, 0.0), end=(1.0, 10.0), ease_func=name).result
    assert both == pytest.approx((expected, 10.0 * expected), abs=1e-12)


def test_an_unknown_easing_from_a_wire_is_an_error() -> None:
    node = ready(Ease, RecordingContext(), alpha=0.5, start=0.0, end=1.0)
    node.ease_func = "easein"
    with pytest.raises(ValueError, match=r"easeFunc must be one of EaseIn, EaseOut, .*, it is 'easein'"):
        node.compute()


def test_samples_are_joined_by_straight_lines_and_constant_beyond_the_ends() -> None:
    samples = {"knots": [0.0, 1.0, 3.0], "values": [10.0, 20.0, 0.0]}
    asked = {-1.0: 10.0, 0.5: 15.0, 1.0: 20.0, 2.0: 10.0, 9.0: 0.0}
    assert {param: computed(Interpolator, param=param, **samples).value for param in asked} == asked
    assert computed(Interpolator, param=1.0).value == 0.0


def test_knots_and_values_of_different_lengths_are_an_error() -> None:
    with pytest.raises(ValueError, match=r"knots, values must be of the same length, it is \[2, 1\]"):
        computed(Interpolator, knots=[0.0, 1.0], values=[1.0])


def test_in_a_graph_a_value_follows_another_from_tick_to_tick(play: Player) -> None:
    playing = play.graph(
        """
        variables: {x: {type: double, default: 0}}
        nodes:
          Tick: OnTick
          Now: {type: ReadVariable, inputs: {variableName: x}}
          Step: {type: InterpolateTo, inputs: {target: 8.0, speed: 30.0, exponent: 1}}
          Write: {type: WriteVariable, inputs: {variableName: x}}
        connections:
          - Tick.tick -> Write.execIn
          - Tick.deltaSeconds -> Step.deltaSeconds
          - Now.value -> Step.current
          - Step.result -> Write.value
        """
    )
    assert playing.each_tick(3, lambda: playing.node("Write").value_out) == pytest.approx([4.0, 6.0, 7.0])


def test_in_a_graph_the_ends_of_an_easing_may_be_of_several_types(play: Player) -> None:
    nodes = {"Ease": "{type: Ease, inputs: {alpha: 0.5, start: 0, end: [2.0, 4.0], easeFunc: Linear}}"}
    assert shown(play, "double[2] Ease.result", nodes) == (1.0, 2.0)
