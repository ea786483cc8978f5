"""Values that are set while a session runs: refused by the bounds of ports, or dropped by the node that cannot use them."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import graphengine as ge
from graphengine.cli import main
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import NodeError
from graphengine.runtime.addresses import find_ports
from graphengine.runtime.command import Command
from graphengine.runtime.parameter_table import Parameter, graph_parameters
from tests.api.conftest import Start

LIMIT, RADIUS, EFFORT = "DiffController.maxLinearSpeed", "DiffController.wheelRadius", "ArtController.effortCommand"
ART = "/dd100/Geometry/base_link/chassis_link/cmd_vel/ArtController"
HOSTILE: list[Any] = [0, -1, 1, 0.0, -1.0, math.nan, math.inf, -math.inf, 1e308, 5e-324, 2**31, 2**63, -(2**63), 2**64]
HOSTILE += ["", "no such", "a\0b", "/", "{", "x" * 100_000, True, None, {}, [[1.0, 2.0, 3.0]]]
HOSTILE += [[], [0.0], [-1.0], [math.nan], [math.inf], [1.0, 2.0, 3.0], [1.0] * 100_000, [1e308] * 2, [-1, -1], [2**40]]
HOSTILE += [["a"], ["a", "b", "c"], [True]]

OUT_OF_BOUNDS = [
    (LIMIT, -1.0, "maxLinearSpeed: expected a value ≥ 0, got -1.0 (unit: m/s)"),
    (LIMIT, math.nan, "maxLinearSpeed: expected a value ≥ 0, got nan (unit: m/s)"),
    (RADIUS, 0.0, "wheelRadius: expected a value > 0, got 0.0 (unit: m)"),
    (RADIUS, -0.049, "wheelRadius: expected a value > 0, got -0.049 (unit: m)"),
    ("ArtController.jointIndices", [0, -1], "jointIndices: expected values ≥ 0, got -1 at [1]"),
]


def dropped(sim: ge.Session) -> dict[str, int]:
    counts = sim._runner.session.services.dropped
    assert counts is not None
    return counts.ticks


def command_of(parameter: Parameter, value: Any) -> Command | None:
    """What sets a parameter to a value; None if the value is refused, which names the input and what is legal."""
    assert parameter.command is not None
    try:
        return parameter.command(value)
    except ge.UsageError as error:
        refusal = str(error)
    assert parameter.name.rpartition(".")[2] in refusal
    assert "expected" in refusal
    return None


def test_no_value_of_a_parameter_ends_a_run() -> None:
    with ge.load("dd100_warehouse", rays="mujoco").session() as sim:
        for claim in sim._runner.scene.claims:
            if claim.direction == "publish":
                sim.subscribe(claim.topic, keep=1)
        sim.step(2)
        graphs, mark = sim._runner.session.graphs, sim.checkpoint()
        found = [p for robot in ("", *sim.robots) for p in graph_parameters(graphs, robot).values()]
        accepted, unusable = 0, set[tuple[str, str]]()
        for parameter, value in itertools.product(found, HOSTILE):
            command = command_of(parameter, value)
            if command is None:
                continue
            accepted += 1
            command.apply(sim._runner.session)
            sim.step(2)
            unusable.update((node, parameter.name) for node in dropped(sim))
            sim.restore(mark)
            assert not dropped(sim)
    assert len(found) >= 40
    assert accepted >= 150
    assert (ART, "cmd_vel.ArtController.effortCommand") in unusable


@pytest.mark.parametrize("scope", ["time", "all"])
def test_a_value_that_its_node_cannot_use_is_dropped_and_counted_and_the_robot_drives_on(
    sim: ge.Session, scope: Any
) -> None:
    sim.set(EFFORT, [1.0, 2.0, 3.0])
    sim.step(5)
    assert dropped(sim) == {ART: 5}
    sim.reset(scope)  # which keeps values that were set
    sim.step(5)
    assert dropped(sim) == {ART: 10}
    sim.set(EFFORT, [])
    sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    sim.run(2.0)
    assert dropped(sim) == {ART: 10}
    assert sim.robots["dd100"].pose.position[0] > 0.5


def test_a_required_input_cannot_be_emptied_while_the_session_runs(sim: ge.Session) -> None:
    ports = [
        port
        for port in find_ports(sim._runner.session.graphs, "*")
        if isinstance(port.value, tuple | str) and port.port.is_missing(type(port.value)())
    ]
    refused = 0
    for port in ports:
        before = port.value
        with pytest.raises(ge.UsageError, match=r"is wired|the input is required, expected a value, got ") as refusal:
            sim.set(port.address, type(before)())
        refused += "required" in str(refusal.value)
        assert port.value == before
    assert refused == 3  # chassis, targets of the transform tree, and camera
    sim.step(2)


def test_the_warning_names_the_port_the_value_and_the_legal_values(start: Start) -> None:
    said: list[str] = []
    sim = start(RAMPS, log=lambda severity, node, text: said.append(text))
    sim.set("Controller.linearVelocity", 1.0)
    sim.impulse("Go")
    sim.step()
    assert said[0].startswith("dt, maxAcceleration, maxDeceleration, maxAngularAcceleration must be above 0")
    assert "it is 0.0; dropped at tick 1" in said[0]


def test_where_bad_values_are_to_stop_a_run_a_value_that_was_set_does_too() -> None:
    with ge.load("dd100_flat").session(bad_values="stop") as sim:
        sim.step()
        sim.set(EFFORT, [1.0, 2.0, 3.0])
        with pytest.raises(NodeError, match="effortCommand has one number for each of 2 joints"):
            sim.step()


def test_a_value_from_the_start_ends_the_run() -> None:
    with (
        ge.load("dd100_flat", set={EFFORT: [1.0, 2.0, 3.0]}).session() as sim,
        pytest.raises(NodeError, match=EFFORT[:3]),
    ):
        sim.step()


RAMPS = """
nodes:
  Go: OnImpulseEvent
  Controller:
    type: DifferentialController
    inputs: {wheelRadius: 0.1, wheelDistance: 0.5, maxAngularAcceleration: 1.0}
connections: [Go.execOut -> Controller.execIn]
"""
"""A node whose inputs are within their bounds, but do not go together: a ramp needs `dt`."""


def test_a_checkpoint_knows_which_values_were_set_while_the_session_ran(start: Start) -> None:
    sim = start(RAMPS)
    sim.step()
    of_the_file = sim.checkpoint()
    sim.set("Controller.linearVelocity", 1.0)
    of_the_run = sim.checkpoint()
    for _ in range(2):
        sim.restore(of_the_run)
        sim.impulse("Go")
        sim.step()
        assert dropped(sim) == {"/World/g/Controller": 1}
    sim.restore(of_the_file)
    sim.impulse("Go")
    with pytest.raises(NodeError, match="for acceleration limits"):
        sim.step()


def test_values_of_a_spawned_robot_can_be_read_and_set() -> None:
    """Its graphs are loaded while the session runs, so no file of it ends the run."""
    with ge.load("dd100_flat").session() as sim:
        sim.spawn("second", "robots/dd100.yaml", position=(0.0, 5.0, 0.03), namespace="second")
        runs = {run.name: run.executor for run in sim._runner.session.graphs}
        assert runs["second/cmd_vel"].faults.set_later == set(range(len(runs["second/cmd_vel"].nodes)))
        assert not runs["dd100/cmd_vel"].faults.set_later


@pytest.mark.parametrize(("address", "value", "words"), OUT_OF_BOUNDS)
def test_a_file_and_a_command_refuse_a_value_alike(sim: ge.Session, address: str, value: Any, words: str) -> None:
    before = sim.value(address)
    with pytest.raises(ge.UsageError) as refusal:
        sim.set(address, value)
    assert str(refusal.value) == f"dd100/cmd_vel/{address.partition('.')[0]}.{words}"
    assert np.array_equal(sim.value(address), before)
    with pytest.raises(CheckError) as found:
        ge.load("dd100_flat", set={address: value})
    (finding,) = [finding for finding in found.value.findings if finding.severity == "error"]
    assert (finding.code, finding.message) == ("G212", f"{address.partition('.')[0]}.{words}")
    assert finding.span is not None


def test_commands_of_the_page_and_of_ctl_are_refused_with_the_same_words(sim: ge.Session) -> None:
    refused = sim.submit("set", {"address": LIMIT, "value": -1.0})
    taken = sim.submit("set", {"address": LIMIT, "value": 0.5})
    sim.step()
    assert str(refused.exception(timeout=0)) == f"dd100/cmd_vel/DiffController.{OUT_OF_BOUNDS[0][2]}"
    assert taken.exception(timeout=0) is None
    assert sim.value(LIMIT) == 0.5


def test_a_zero_from_a_wire_is_illegal_for_inputs_whose_default_zero_means_not_set(start: Start) -> None:
    text = """
nodes: {Tick: OnPlaybackTick, Zero: ConstantDouble, Controller: DifferentialController}
connections:
  - Tick.tick -> Controller.execIn
  - Zero.inputs:value -> Controller.wheelDistance
  - Zero.inputs:value -> Controller.wheelRadius
"""
    sim = start(text)
    sim.step()
    assert dropped(sim) == {"/World/g/Controller": 1}


def test_an_input_may_be_set_to_the_value_that_it_has(start: Start) -> None:
    sim = start("nodes: {Tick: OnPlaybackTick, Scan: ROS2PublishLaserScan}\nconnections: [Tick.tick -> Scan.execIn]")
    sim.set("Scan.numRows", 0)
    with pytest.raises(ge.UsageError, match=r"Scan.numRows: expected a value ≥ 1 and ≤ 1, got 2"):
        sim.set("Scan.numRows", 2)
    sim.set("Scan.numRows", 1)
    with pytest.raises(ge.UsageError, match="got 0"):
        sim.set("Scan.numRows", 0)


DISTURBANCES: dict[str, dict[str, Any]] = {
    "push": {"entity": "dd100", "impulse": [0.0, 1000.0, 0.0], "at": [10.0, 0.0, 0.0]},
    "move": {"entity": "dd100", "angular": [0.0, 0.0, 1000.0]},
}


@pytest.mark.parametrize("command", DISTURBANCES)
def test_a_world_that_a_command_makes_diverge_is_put_back_and_the_run_goes_on(command: str, tmp_path: Path) -> None:
    said = list[str]()
    recorded = tmp_path / "run.mcap"
    scene = ge.load("dd100_flat", rays="mujoco")
    with scene.session(record=recorded, log=lambda severity, node, text: said.append(text)) as sim:
        sim.step(5)
        sim._runner.command(command, **DISTURBANCES[command])
        sim.step(60)
        assert (sim.tick, sim.state) == (65, "paused")
        assert all(math.isfinite(number) for number in sim.robots["dd100"].pose.position)
    assert sum("the world is back in its initial state" in text for text in said) == 1
    assert main(["replay", str(recorded)]) == 0


def test_a_world_that_a_command_makes_diverge_ends_a_run_that_bad_values_end() -> None:
    with ge.load("dd100_flat", rays="mujoco").session(bad_values="stop") as sim:
        sim._runner.command("move", **DISTURBANCES["move"])
        with pytest.raises(ge.PhysicsError, match="diverged"):
            sim.step(60)
