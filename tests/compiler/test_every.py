"""`every:` lets some of a node's executions through, as the gates do that Isaac's users build by hand."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from graphengine.compiler.every_gates import EveryHz, EveryTicks, rate
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.node.clock import Clock
from graphengine.nodes.core.flow import IsaacSimulationGate, OgnIsaacRunOneSimulationFrame
from graphengine.runtime import check
from graphengine.testing import RecordingContext
from tests.compiler.conftest import MakeBench, MakeFile, MakePlay
from tests.compiler.harness import Bench, planned, write


def graph(every: str) -> str:
    return f"""
        nodes:
          Tick: Tick
          Do: {{type: Do, every: {every}}}
        connections: [Tick.tick -> Do.execIn]
        """


def running(run: Bench, ticks: int) -> list[int]:
    """Numbers of the ticks in which something was written, of those from 1 on."""
    return [number for number in range(1, ticks + 1) if run.tick()]


def test_ticks_lets_every_nth_execution_through(bench: MakeBench) -> None:
    assert running(bench(graph("{ticks: 3}")), 10) == [3, 6, 9]


def test_once_lets_the_first_execution_since_play_through(bench: MakeBench) -> None:
    run = bench(graph("once"))
    assert running(run, 5) == [1]
    run.stop()
    assert running(run, 5) == [1]


@pytest.mark.parametrize(
    ("hz", "expected"),
    [(10, [1, 6, 12, 18, 24]), (7, [1, 9, 18]), (60, list(range(1, 25))), (1000, list(range(1, 25)))],
)
def test_hz_lets_the_first_execution_at_or_after_each_period_through(
    play: MakePlay, hz: float, expected: list[int]
) -> None:
    run = play(graph(f"{{hz: {hz}}}"))
    assert [number for number in range(1, 25) if run.tick()] == expected


def test_periods_without_an_execution_are_skipped(play: MakePlay) -> None:
    run = play(
        """
        nodes:
          Seldom: {type: Every, inputs: {n: 20}}
          Do: {type: Do, every: {hz: 10}}
        connections: [Seldom.fired -> Do.execIn]
        """
    )
    assert [number for number in range(1, 70) if run.tick()] == [20, 40, 60]


def test_a_graph_of_physics_steps_counts_the_time_of_steps(play: MakePlay) -> None:
    run = play("runs: physics_step\n" + graph("{hz: 60}").replace("\n        ", "\n"), substeps=4)
    assert [len(run.tick()) for _ in range(4)] == [2, 1, 1, 1]  # the first step, then the last of each tick


@given(st.fractions(min_value="1/100", max_value=500), st.integers(1, 300), st.lists(st.booleans(), max_size=100))
def test_hz_follows_the_rule_at_all_rates(hz: Fraction, tick_rate: int, executed: list[bool]) -> None:
    rate, context = float(hz), RecordingContext()
    context.clock = Clock((1, tick_rate))
    gate, due = EveryHz(hz=rate), 0
    gate.setup(context)
    for frame, runs in enumerate(executed, 1):
        context.clock.set_frame(frame)
        if not runs:
            continue
        begun = frame * Fraction(repr(rate)) // tick_rate
        assert bool(gate.compute()) == (begun >= due)
        due = max(due, begun + 1)


@pytest.mark.parametrize(("before", "after", "expected"), [(10, 1, [8]), (1, 10, [8, 9, 10])])
def test_a_rate_that_changes_while_the_graph_runs_holds_from_there_on(
    before: float, after: float, expected: list[int]
) -> None:
    context = RecordingContext()
    context.clock = clock = Clock((1, 4))
    gate = EveryHz(hz=before)
    gate.setup(context)
    for frame in range(1, 8):
        clock.set_frame(frame)
        gate.compute()
    gate.hz = after
    gate.setup(context)
    fired = []
    for frame in range(8, 11):
        clock.set_frame(frame)
        fired += [frame] * (gate.compute() is not None)
    assert fired == expected


@given(st.integers(1, 5), st.integers(0, 20))
def test_every_ticks_fires_like_isaac_simulation_gate(n: int, executions: int) -> None:
    ours, theirs = EveryTicks(ticks=n), IsaacSimulationGate(step=n)
    assert [bool(ours.compute()) for _ in range(executions)] == [bool(theirs.compute()) for _ in range(executions)]


def test_every_once_fires_like_the_gate_of_one_simulation_frame(bench: MakeBench) -> None:
    theirs = OgnIsaacRunOneSimulationFrame()
    assert running(bench(graph("once")), 4) == [n for n in range(1, 5) if theirs.compute()]


def test_every_on_an_event_gates_its_outputs(bench: MakeBench) -> None:
    run = bench(
        """
        nodes:
          Ends: {type: TwoEnds, every: {ticks: 2}}
          Even: Do
          Odd: Do
        connections: [Ends.even -> Even.execIn, Ends.odd -> Odd.execIn]
        """
    )
    assert run.ticks(8) == [[], [], ["Odd 0"], ["Even 0"], [], [], ["Odd 0"], ["Even 0"]]


def test_an_event_that_runs_several_times_in_a_tick_counts_each(bench: MakeBench) -> None:
    run = bench(
        """
        nodes:
          On: {type: OnMessage, every: {ticks: 2}}
          Do: Do
        connections: [On.received -> Do.execIn, On.value -> Do.a]
        """
    )
    for value in range(5):
        run.services.queues["messages"].post(float(value))
    assert run.tick() == ["Do 1", "Do 3"]


def test_each_execution_input_has_a_gate_and_control_pins_have_none(bench: MakeBench) -> None:
    run = bench(
        """
        nodes:
          Ends: TwoEnds
          Tick: Tick
          Join: {type: Join, every: {ticks: 2}}
        connections: [Ends.odd -> Join.first, Tick.tick -> Join.second, Tick.tick -> Join.hold]
        """
    )
    assert run.ticks(4) == [
        ["Join first=0 second=0 hold=1"],
        ["Join first=0 second=1 hold=1"],
        ["Join first=1 second=0 hold=1"],
        ["Join first=0 second=1 hold=1"],
    ]


def test_a_gate_keeps_the_order_of_nodes(file: MakeFile) -> None:
    text = """
        nodes:
          Tick: Tick
          A: Do
          B: {type: Do, every: {ticks: 1}}
          C: Do
        connections: [Tick.tick -> C.execIn, Tick.tick -> B.execIn, Tick.tick -> A.execIn]
        """
    assert Bench(file(text)).setup().tick() == ["C 0", "B 0", "A 0"]


def test_every_can_have_the_value_of_a_parameter(bench: MakeBench) -> None:
    text = "parameters: {n: {type: int, default: 2}}\n" + graph("{ticks: $(n)}").replace("\n        ", "\n")
    assert running(bench(text), 5) == [2, 4]


@pytest.mark.parametrize(
    ("every", "column"),
    [
        ("{hz: 0}", 30),
        ("{hz: -1}", 30),
        ("{ticks: 0}", 33),
        ("{ticks: 1.5}", 33),
        ("{hz: 1, ticks: 1}", 18),
        ("{}", 18),
        ("twice", 25),
        ("{rate: 3}", 26),
    ],
)
def test_an_illegal_value_of_every_is_an_error_at_its_position(file: MakeFile, every: str, column: int) -> None:
    findings = Findings()
    planned(file(f"nodes:\n  Do: {{type: Do, every: {every}}}\n"), findings)
    (found,) = findings.items
    assert found.span is not None
    assert (found.code[:3], found.span.line, found.span.column) == ("G10", 3, column)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("nodes: {Add: {type: Add, every: once}}", "a data node"),
        ("evaluator: push\nnodes: {Tick: {type: Tick, every: once}}", "a push graph"),
    ],
)
def test_every_at_a_node_that_is_not_executed_is_an_error(file: MakeFile, text: str, why: str) -> None:
    findings = Findings()
    planned(file(text), findings)
    assert [found.code for found in findings.errors] == ["G109"]
    assert why.removeprefix("a ") in findings.errors[0].message


def test_every_at_a_subgraph_is_an_error(file: MakeFile) -> None:
    findings = Findings()
    planned(file("{graph: g, nodes: {Part: {subgraph: part.yaml, every: once}}}"), findings)
    assert [found.code for found in findings.items] == ["G109"]


def test_a_node_that_raises_behind_a_gate_is_named_with_its_own_line(tmp_path: Path) -> None:
    run = Bench(write(tmp_path, graph("{ticks: 2}").replace("type: Do", "type: Raise")), keep_going=True).setup()
    run.ticks(2)
    assert len(run.faults) == 1
    assert "g.yaml:4:3: node Do" in str(run.faults[0])


def test_rates_count_gates(file: MakeFile) -> None:
    graph = Bench(
        file("""
        nodes:
          Tick: {type: Tick, every: {ticks: 2}}
          Plain: Do
          Slow: {type: Do, every: {hz: 10}}
          Fast: {type: Do, every: {hz: 50}}
          Then: {type: Do, every: {ticks: 3}}
          Once: {type: Do, every: once}
          Door: Door
          Behind: {type: Do, every: {hz: 10}}
        connections:
          - Tick.tick -> Plain.execIn
          - Tick.tick -> Slow.execIn
          - Slow.execOut -> Then.execIn
          - Tick.tick -> Fast.execIn
          - Tick.tick -> Once.execIn
          - Tick.tick -> Door.execIn
          - Door.execOut -> Behind.execIn
        """)
    ).graph
    rates = {instance.id: rate(graph, instance.index, 60.0) for instance in graph.instances if not instance.part_of}
    paced = {"Tick": 60.0, "Plain": 30.0, "Slow": 10.0, "Fast": 30.0, "Then": pytest.approx(10 / 3), "Door": 30.0}
    assert rates == {**paced, "Once": None, "Behind": None}


@pytest.mark.parametrize(
    ("runs", "paces", "told"),
    [
        ("tick", "Tick: {hz: 60}, A: {hz: 60}", []),
        ("tick", "A: {hz: 61}", ["A"]),
        ("physics_step", "A: {hz: 61}", []),
        ("physics_step", "A: {hz: 241}", ["A"]),
        ("tick", "Tick: {hz: 10}, A: {hz: 20}, B: {hz: 20}", ["A", "B"]),
        ("tick", "Tick: {ticks: 3}, A: {hz: 30}", ["A"]),
        ("tick", "Tick: once, A: {hz: 60}", []),
    ],
)
def test_a_rate_above_the_rate_of_passes_is_a_warning(file: MakeFile, runs: str, paces: str, told: list[str]) -> None:
    every = yaml.safe_load(f"{{{paces}}}")
    nodes = {name: {"type": kind} for name, kind in (("Tick", "Tick"), ("A", "Do"), ("B", "Do"))}
    for name, pace in every.items():
        nodes[name]["every"] = pace
    wires = ["Tick.tick -> A.execIn", "A.execOut -> B.execIn"]
    findings = Findings()
    graph = planned(file(yaml.safe_dump({"graph": "g", "runs": runs, "nodes": nodes, "connections": wires})), findings)
    assert graph is not None
    check.lint_rates([graph], DryWorld(Stage(), (1, 60), 4), findings)
    assert [(found.code, found.message.split()[0]) for found in findings.items] == [("W106", name) for name in told]


@pytest.mark.parametrize(("runs", "rate"), [("tick", 60.0), ("physics_step", 240.0)])
def test_a_publisher_has_the_rate_at_which_its_graph_is_executed(file: MakeFile, runs: str, rate: float) -> None:
    text = f"{{graph: g, runs: {runs}, nodes: {{T: Tick, A: Do}}, connections: [T.tick -> A.execIn]}}"
    findings = Findings()
    graph = planned(file(text), findings)
    assert graph is not None
    claims = check.check_graphs([graph], DryWorld(Stage(), (1, 60), 4), findings, prims_known=False)
    assert [claim.rate for claim in claims] == [pytest.approx(rate)]
