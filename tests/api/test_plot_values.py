"""The values that viewers plot: numbers of ports, messages and bodies, parts of other values, and mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.testing import session

pytest.importorskip("viser", reason="the extra view is not installed")

import itertools

from graphengine.api import plot_values
from graphengine.api.plot_values import PlotValues
from graphengine.api.topics import Subscription
from tests.view.harness import Viewer, viewed

RAMP = """graph: ramp
variables: {height: {type: double, default: 2.5}}
nodes:
  Tick: OnPlaybackTick
  Place: {type: MakeVector3, inputs: {y: 2.0, z: 0.5}}
  Break: BreakVector3
  Twice: Multiply
  Say: {type: ROS2Publisher, inputs: {topicName: /twice, messagePackage: std_msgs, messageName: Float64}}
  Name: {type: ConstantString, inputs: {value: "a name"}}
connections:
  - Tick.time -> Twice.a
  - Tick.time -> Place.x
  - Place.tuple -> Break.tuple
  - Break.y -> Twice.b
  - Twice.product -> Say.data
  - Tick.tick -> Say.execIn
"""
Make = Callable[..., PlotValues]


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[ge.Session]:
    path = tmp_path / "ramp.yaml"
    path.write_text(RAMP, encoding="utf-8")
    with session(path) as made:
        yield made


def plotted(sim: ge.Session, *texts: str, ticks: int = 3) -> tuple[PlotValues, dict[str, Any]]:
    """The values of expressions after each of some ticks."""
    runner = sim._runner
    values = PlotValues(
        runner.session, runner.scene.definitions, lambda topic: Subscription(runner, topic, None, keep=1)
    )
    values.want(texts)
    begin = sim.time
    for _ in range(ticks):
        sim.step()
        values.sample(sim.time)
    taken = values.take()
    assert taken is not None
    assert taken.times == pytest.approx([begin + (tick + 1) / 60 for tick in range(ticks)])
    return values, dict(taken.values)


def test_numbers_are_those_of_the_session_in_each_tick(sim: ge.Session) -> None:
    port, message = 'port("ramp/Twice.outputs:product")', 'message("/twice").data'
    texts = (port, f"{port} ** 2 + 1", message, 'variable("ramp/height")', "hypot(3.0, time() * 0.0 + 4.0)")
    values, found = plotted(sim, *texts)
    twice = found[port]
    assert [after - before for before, after in itertools.pairwise(twice)] == pytest.approx([2 / 60] * 2)
    assert found[f"{port} ** 2 + 1"] == pytest.approx([value**2 + 1 for value in twice])
    assert found[message][1:] == pytest.approx(twice[:-1], abs=2 / 60 + 1e-9)
    assert found['variable("ramp/height")'] == [2.5] * 3
    assert found["hypot(3.0, time() * 0.0 + 4.0)"] == [5.0] * 3
    assert values.status == {}


def test_a_value_that_is_not_one_number_offers_its_parts(sim: ge.Session) -> None:
    place, message = 'port("ramp/Place.outputs:tuple")', 'message("/twice")'
    values, found = plotted(sim, place, message)
    assert values.status[place] == {"choices": ["[0]", "[1]", "[2]"]}
    assert values.status[message] == {"choices": [".data"]}
    assert found[place] == [None] * 3
    _, parts = plotted(sim, f"{place}[1]")
    assert parts[f"{place}[1]"] == [2.0] * 3


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1 +", "not an expression"),
        ('port("ramp/No.value")', "no node 'ramp/No'"),
        ('message("/nothing")', "no graph of this session publishes or receives /nothing"),
        ("().__class__", "not allowed"),
        ("open('/etc/passwd')", "there is no name 'open'"),
        ("[[0 for a in [1] * 9000] for b in [1] * 9000]", "steps"),
        ('port("ramp/Name.inputs:value")', "text is not a number"),
        ("1" * 501, "at most 500 characters"),
    ],
)
def test_a_mistake_is_told_and_ends_nothing(sim: ge.Session, text: str, reason: str) -> None:
    values, found = plotted(sim, text, "1.0")
    assert reason in values.status[text]["error"]
    assert found[text] == [None] * 3
    assert found["1.0"] == [1.0] * 3


def test_there_is_a_most_of_series_and_of_unsent_samples(sim: ge.Session, monkeypatch: pytest.MonkeyPatch) -> None:
    values, _ = plotted(sim, *(f"{number}.0" for number in range(plot_values.MAX_SERIES + 1)))
    assert list(values.status) == [f"{plot_values.MAX_SERIES}.0"]
    monkeypatch.setattr(plot_values, "MAX_SAMPLES", 10)
    for tick in range(25):
        values.sample(tick)
    taken = values.take()
    assert taken is not None
    assert len(taken.times) <= 10
    assert taken.times[-1] == 24
    assert {len(column) for column in taken.values.values()} == {len(taken.times)}


def test_a_viewer_gets_each_sample_until_it_plots_nothing_any_more() -> None:
    text = 'pose("dd100").position[2]'

    def play(viewer: Viewer) -> Any:
        viewer.ask(ask="plots", series=[text, 5])
        times: list[float] = []
        while len(times) < 30:
            times += viewer.wait("samples")["times"]
            del viewer.told["samples"]
        viewer.ask(ask="plots", series=[])
        return times

    with session("dd100_flat") as sim:
        times = viewed(sim, play)
        steps = [after - before for before, after in itertools.pairwise(times)]
        assert steps == pytest.approx([1 / 60] * len(steps))
        feed = sim._runner.feed
        assert feed is not None
        sim.step(2)
        assert not feed.plots.wanted
