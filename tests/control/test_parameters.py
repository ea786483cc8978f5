"""The parameter by which `ros2 param` sets how fast simulation time passes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.control.parameters import offer_parameters
from graphengine.control.service_host import Offers
from graphengine.messages.definitions import DEFINITIONS
from tests.control.simulators import Simulator, simulator

NAME = "real_time_factor"
NOT_SET, BOOL, INTEGER, DOUBLE = range(4)


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[Simulator]:
    with simulator(tmp_path, pace=1.0) as running:
        offer_parameters(Offers(running.transport, running.complaints.append), "/warehouse", running.run.desk)
        yield running


def ask(sim: Simulator, service: str, **fields: Any) -> Any:
    name = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in service).lstrip("_")
    return sim.ask(f"warehouse/{name}", f"rcl_interfaces/srv/{service}", **fields)


def parameter(value: float, name: str = NAME, kind: int | None = None) -> Any:
    found = DEFINITIONS.initial("rcl_interfaces/msg/Parameter")
    found.name, found.value.type = name, kind if kind is not None else INTEGER if isinstance(value, int) else DOUBLE
    if isinstance(value, int):
        found.value.integer_value = value
    else:
        found.value.double_value = value
    return found


def factor(sim: Simulator) -> float:
    (value,) = ask(sim, "GetParameters", names=[NAME]).values
    assert value.type == DOUBLE
    return float(value.double_value)


@pytest.mark.parametrize(("value", "pace"), [(0.5, 0.5), (2, 2.0), (0.0, None), (0.01, 0.01)])
@pytest.mark.parametrize("atomically", [True, False])
def test_a_factor_that_is_set_is_the_pace(sim: Simulator, value: float, pace: float | None, atomically: bool) -> None:
    assert factor(sim) == 1.0
    if atomically:
        assert ask(sim, "SetParametersAtomically", parameters=[parameter(value)]).result.successful
    else:
        assert [each.successful for each in ask(sim, "SetParameters", parameters=[parameter(value)]).results] == [True]
    assert factor(sim) == float(value)
    assert sim.session.pace == pace


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (parameter(-1.0), "cannot be -1"),
        (parameter(0.001), "cannot be 0.001"),
        (parameter(math.nan), "cannot be nan"),
        (parameter(math.inf), "cannot be inf"),
        (parameter(1.0, kind=BOOL), "must be a number"),
        (parameter(1.0, name="use_sim_time"), "unknown parameter 'use_sim_time'"),
    ],
)
def test_what_cannot_be_set_is_refused_and_of_all_at_once_nothing_is(sim: Simulator, wrong: Any, words: str) -> None:
    (result,) = ask(sim, "SetParameters", parameters=[wrong]).results
    assert (result.successful, words in result.reason) == (False, True)
    whole = ask(sim, "SetParametersAtomically", parameters=[parameter(3.0), wrong]).result
    assert (whole.successful, words in whole.reason) == (False, True)
    assert factor(sim) == 1.0
    good, bad = ask(sim, "SetParameters", parameters=[parameter(3.0), wrong]).results
    assert (good.successful, bad.successful, factor(sim)) == (True, False, 3.0)


def test_the_parameter_is_listed_and_described(sim: Simulator) -> None:
    assert list(ask(sim, "ListParameters").result.names) == [NAME]
    assert list(ask(sim, "ListParameters", prefixes=["qos_overrides"]).result.names) == []
    assert ask(sim, "GetParameterTypes", names=[NAME, "other"]).types.tolist() == [DOUBLE, NOT_SET]
    assert [value.type for value in ask(sim, "GetParameters", names=["other"]).values] == [NOT_SET]
    described, unknown = ask(sim, "DescribeParameters", names=[NAME, "other"]).descriptors
    assert (described.type, unknown.type) == (DOUBLE, NOT_SET)
    assert "wall time" in described.description


def test_nothing_is_done_where_nothing_is_asked_for(sim: Simulator) -> None:
    assert ask(sim, "SetParameters").results == []
    assert ask(sim, "SetParametersAtomically").result.successful
    assert factor(sim) == 1.0
