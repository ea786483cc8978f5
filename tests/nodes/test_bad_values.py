"""Values that came over wires and that nodes cannot use: BadValueError, before anything changed, and nothing else."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from random import Random
from typing import Any

import pytest

from graphengine.format.errors import GraphError
from graphengine.node import BadValueError, Node, PortType
from graphengine.node.port import Port
from graphengine.node.types import equal
from tests.nodes.harness import Player
from tests.nodes.test_ports import TYPES
from tests.nodes.trial import ROUNDS, Trial, inputs_of, play_wired, spoiled, trials
from tests.nodes.wire_values import a_value, bad_inputs, legal_inputs

WIRED = sorted(name for name, cls in TYPES.items() if cls.compute is not Node.compute and Trial(name).wired)
"""Types that compute with inputs whose values wires may change from tick to tick."""
every_type = pytest.mark.parametrize("name", WIRED)


@pytest.fixture(autouse=True)
def short_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Node, "max_pushes", ROUNDS)


RAN_ALREADY = {"graphengine.action.WhileLoop"}
"""Types that refuse a value after the rounds that it asked for."""


def check_refusal(trial: Trial, refusal: BadValueError) -> None:
    names = {port.name for port in trial.cls.fields.values()} | {"message"}
    assert set(refusal.port.split(", ")) <= names, refusal.port


def fuzz(trial: Trial, count: int) -> Iterator[dict[str, Any]]:
    """So many sets of values, the same each time; each has a value for some input."""
    random = Random(trial.cls.type_name)
    drawn = iter(lambda: bad_inputs(random, trial), None)
    return itertools.islice(filter(None, drawn), count)


def try_values(trial: Trial) -> None:
    for values in fuzz(trial, 20):
        before, sent = trial.seen(), trial.sent()
        refusal = trial.tick(values)
        if refusal is not None:
            check_refusal(trial, refusal)
            if trial.cls.type_name not in RAN_ALREADY:
                assert (trial.seen(), trial.sent()) == (before, sent), values
        before = trial.seen()
        refusal = trial.update()
        if refusal is not None:
            assert trial.seen() == before, values


@every_type
def test_any_value_is_used_or_refused_and_a_refusal_changes_nothing(name: str) -> None:
    for trial in trials(name):
        try_values(trial)


@every_type
def test_refused_values_leave_no_trace_in_the_state_of_a_node_a_hundred_ticks_later(name: str) -> None:
    fed, spared, clean = Trial(name), Trial(name), Trial(name)
    for values in fuzz(fed, 10):
        refused = fed.tick(values) is not None
        spared.tick(values, execute=not refused)
        clean.tick()
        for trial in (fed, spared, clean):
            trial.update()
    for _ in range(100):
        for trial in (fed, spared, clean):
            trial.tick()
            trial.update()
    assert fed.seen() == spared.seen()
    for field in fed.seen():
        value = getattr(fed.node, field, 0.0)
        assert not spoiled(value) or spoiled(getattr(clean.node, field)), field


@every_type
def test_no_value_from_a_wire_ends_a_run(name: str, play: Player) -> None:
    trial = Trial(name)
    playing, source = play_wired(play, trial)
    reached = 0
    for values in fuzz(trial, 10):
        for field, value in values.items():
            setattr(source, f"out_{field}", value)
        playing.tick()
        reached += any(getattr(playing.node("Node"), field) is value for field, value in values.items())
    assert reached


def can_be_set(trial: Trial, port: Port) -> bool:
    """Whether a graph file can do without a wire to an input."""
    needed = port.required and equal(trial.good[port.field], port.default)
    return isinstance(port.type, PortType) and port.type.base != "any" and not needed and port.name != "serverHandle"


@pytest.mark.parametrize("name", [name for name in WIRED if not name.endswith("ScriptNode")])  # a script may raise
def test_no_value_that_is_set_during_a_run_ends_the_run(name: str, play: Player) -> None:
    trial, random = Trial(name), Random(name)
    settable = [port for port in inputs_of(trial.cls) if can_be_set(trial, port)]
    trial.wired = [port for port in trial.wired if port not in settable]
    playing, _ = play_wired(play, trial)
    for _ in range(10):
        for port in settable:
            value = a_value(random, trial.types[port.field], port.tokens)
            with contextlib.suppress(GraphError):
                playing.command("set", address=f"Node.inputs:{port.name}", value=value)
        playing.tick()


UNWIRED = {"IsaacReadEnvVar", "IsaacSetCameraOnRenderProduct", "QuinticPathPlanner", "ROS2Publisher", "ROS2Subscriber"}
UNWIRED |= {
    "OgnROS2ServiceClient",
    "OgnROS2ServiceServerRequest",
    "OgnROS2ServiceServerResponse",
    "ROS2ActionClient",
    "ROS2ActionServerFeedback",
    "ROS2ActionServerGoal",
    "ROS2ActionServerResult",
    "ROS2PublishLaserScan",
}
"""Types that need literals before the first tick, or the surroundings of a trial."""
READS_IN_SETUP = [
    name
    for name, cls in TYPES.items()
    if cls.compute is not Node.compute
    and name.rpartition(".")[2] not in {*UNWIRED, "ScriptNode"}  # a script that raises is a fault
    and any(port.setup for port in inputs_of(cls))
]


@pytest.mark.parametrize("name", READS_IN_SETUP)
def test_no_value_from_a_wire_that_setup_reads_ends_a_run(name: str, play: Player) -> None:
    trial = Trial(name)
    trial.wired = [port for port in inputs_of(trial.cls) if port.setup and port.type != PortType("bundle")]
    playing, source = play_wired(play, trial)
    for values in fuzz(trial, 10):
        for field, value in values.items():
            setattr(source, f"out_{field}", value)
        playing.tick()


@every_type
def test_no_finite_legal_value_is_refused(name: str) -> None:
    single, *arrays = trials(name)
    for trial in (single, *(other for other in arrays if other.tick() is None)):
        random = Random(name)
        for _ in range(20):
            values = legal_inputs(random, trial)
            assert trial.tick(values) is None, values
            assert trial.update() is None, values


def test_node_types_without_trial_read_all_their_inputs_in_setup() -> None:
    others = [cls for cls in TYPES.values() if cls.compute is not Node.compute and cls.type_name not in WIRED]
    assert [cls.type_name for cls in others if not all(port.setup for port in inputs_of(cls))] == []
    assert len(WIRED) >= 200
