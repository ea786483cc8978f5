"""Metrics, compared with the formulae of a falling ball and with a naive implementation of each definition."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import graphengine as ge
from graphengine.api.expectations.metrics import FOLDS
from graphengine.format.errors import UsageError

WORLD = '<mujoco><worldbody><body name="ball" pos="0 0 2"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
G, STEP = 9.81, 0.01


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[ge.Session]:
    (tmp_path / "world.xml").write_text(WORLD, encoding="utf-8")
    physics = {"tick_rate": 100, "substeps": 1}
    with ge.load({"scene": "s", "world": "world.xml", "physics": physics}, folder=tmp_path).session() as session:
        yield session


def test_a_falling_ball_has_the_metrics_of_its_formulae(sim: ge.Session) -> None:
    speed = sim.measure(ge.metric(min="velocity('ball').linear[2]"))
    height = sim.measure(ge.metric(max='pose("ball").position[2]'))
    mean = sim.measure(ge.metric(mean="abs(velocity('ball').linear[2])"))
    final = sim.measure(ge.metric(final="pose('ball').position[2]"))
    low = sim.measure(ge.metric(time_to="pose('ball').position[2] < 1.5"))
    never = sim.measure(ge.metric(time_to="pose('ball').position[2] > 2"))
    sim.step(40)
    assert speed.value == pytest.approx(-G * 40 * STEP)
    assert height.value == pytest.approx(2.0 - G * STEP**2)  # after the first tick
    assert mean.value == pytest.approx(G * STEP * 41 / 2)
    assert final.value == pytest.approx(2.0 - G * STEP**2 * 40 * 41 / 2)
    assert low.value == pytest.approx(next(n for n in range(40) if G * STEP**2 * n * (n + 1) / 2 > 0.5) * STEP)
    assert never.value is None


def test_times_count_from_the_beginning_of_the_measurement(sim: ge.Session) -> None:
    sim.step(10)
    late = sim.measure(ge.metric(time_to="time >= 0.25"))
    sim.step(30)
    assert late.value == pytest.approx(0.15)


def test_a_reset_restarts_a_metric_and_a_checkpoint_restores_it(sim: ge.Session) -> None:
    mean = sim.measure(ge.metric(mean="time"))
    sim.step(3)
    mark = sim.checkpoint()
    sim.step(5)
    sim.restore(mark)
    sim.step(1)
    assert mean.value == pytest.approx((1 + 2 + 3 + 4) / 4 * STEP)
    sim.reset()
    sim.step(2)
    assert mean.value == pytest.approx(1.5 * STEP)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30))
def test_each_operator_agrees_with_its_definition(samples: list[float]) -> None:
    values = {}
    for name, fold in FOLDS.items():
        value = samples[0]
        for number, sample in enumerate(samples[1:], 2):
            value = fold(value, sample, number)
        values[name] = value
    mean = sum(samples) / len(samples)
    naive = {"min": min(samples), "max": max(samples), "final": samples[-1], "time_to": samples[0]}
    assert values == pytest.approx(naive | {"mean": mean}, abs=1e-6)


def test_an_invalid_metric_is_refused(sim: ge.Session) -> None:
    with pytest.raises(UsageError, match=r"expected one operator, got none\n  operators: .*time_to"):
        ge.metric()
    with pytest.raises(UsageError, match="got min, max"):
        ge.metric(min="time", max="time")
    with pytest.raises(UsageError, match="got median"):
        ge.metric(median="time")
    with pytest.raises(UsageError, match="nobody"):
        sim.measure(ge.metric(max="tilt('nobody')"))
    sim.measure(ge.metric(max="pose('ball').position"))
    with pytest.raises(UsageError, match="expected a number"):
        sim.step()
