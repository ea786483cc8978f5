"""Values of ports, as users read and set them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import graphengine as ge
from tests.api.conftest import Start

GRAPH = """
variables: {speed: {type: double, default: 1.5}, way: {type: "double[]", default: [1.0, 2.0]}}
nodes: {Tick: OnPlaybackTick, Fails: {type: api.Fails, inputs: {label: first}}}
connections: [Tick.tick -> Fails.execIn]
"""


def test_a_port_is_read_by_as_much_of_its_address_as_no_other_has(sim: ge.Session) -> None:
    sim.step()
    position = sim.value("dd100/joint_states/ComputeOdom.position")
    assert sim.value("ComputeOdom.outputs:position") == position
    assert sim.value("DiffController.wheelRadius") == sim.value("DiffController.inputs:wheelRadius") == 0.049
    assert sim.values("*/ComputeOdom.position") == {"dd100/joint_states/ComputeOdom.position": position}
    assert sim.values("Diff*.max*arSpeed") == {
        "dd100/cmd_vel/DiffController.maxLinearSpeed": 1.3,
        "dd100/cmd_vel/DiffController.maxAngularSpeed": 4.0,
    }


def test_an_array_is_a_view_that_cannot_be_written(start: Start) -> None:
    sim = start(GRAPH)
    sim.step(3)
    squares = sim.value("Fails.squares")
    assert squares.tolist() == [0.0, 1.0, 4.0]
    assert np.shares_memory(squares, sim.value("Fails.squares"))
    for array in (squares, sim.variables("g")["way"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    assert sim.variables("g")["speed"] == 1.5


def test_values_of_robots_that_come_are_found_and_of_those_that_go_are_not(sim: ge.Session) -> None:
    assert sim.value("DiffController.wheelRadius") == 0.049
    sim.spawn("second", "robots/dd100.yaml", position=(0.0, 5.0, 0.03), namespace="second")
    with pytest.raises(ge.UsageError, match="could mean 2 ports"):
        sim.value("DiffController.wheelRadius")
    sim.remove("second")
    assert sim.value("DiffController.wheelRadius") == 0.049


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("ComputeOdm.position", "no node 'ComputeOdm'\n  did you mean 'ComputeOdom'?"),
        ("joint_state/ComputeOdom.position", "did you mean 'dd100/joint_states/ComputeOdom'?"),
        ("ComputeOdom.positon", "IsaacComputeOdometry has no port with a value 'positon'\n  did you mean 'position'?"),
        ("ComputeOdom.execOut", "no port with a value 'execOut'"),
        ("ComputeOdom", "write NODE.PORT"),
    ],
)
def test_a_wrong_address_tells_the_nearest(sim: ge.Session, address: str, words: str) -> None:
    for read in (sim.value, sim.values):
        with pytest.raises(ge.UsageError) as caught:
            read(address)
        assert words in str(caught.value)


@pytest.mark.parametrize("value", [np.int64(4), 4, np.array(4)])
def test_numbers_of_numpy_are_set_like_those_of_python(start: Start, value: Any) -> None:
    sim = start(GRAPH)
    sim.set("Fails.at", value)
    assert sim.value("Fails.at") == 4


@pytest.mark.parametrize(
    ("value", "words"), [("four", "is an int64: expected"), (4.5, "is an int64: expected"), (object(), "got <object")]
)
def test_a_value_of_another_type_is_told(start: Start, value: Any, words: str) -> None:
    with pytest.raises(ge.UsageError, match=words):
        start(GRAPH).set("Fails.at", value)


def test_a_star_lists_the_addresses_of_all_ports(sim: ge.Session) -> None:
    everything = sim.values("*")
    assert everything.keys() == sim.values("*.*").keys()
    assert "dd100/joint_states/ComputeOdom.position" in everything
