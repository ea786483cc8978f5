"""Push graphs: every node in every pass, in the order of all wires."""

from __future__ import annotations

import pytest

from graphengine.compiler.every_gates import rate
from graphengine.format.diagnostics import Findings
from tests.compiler.conftest import MakeBench, MakeFile
from tests.compiler.harness import planned


def test_every_node_runs_whether_anything_fires_it_or_not(bench: MakeBench) -> None:
    run = bench("evaluator: push\nnodes: {Alone: Do, Ticket: Ticket}")
    assert run.ticks(2) == [["Alone 0"], ["Alone 0"]]
    assert run["Ticket"].number == 2.0


def test_nodes_run_in_the_order_of_all_wires(bench: MakeBench) -> None:
    run = bench(
        """
        evaluator: push
        nodes: {Last: Do, Second: Do, Add: {type: Add, inputs: {b: 1.0}}, First: {type: Do, inputs: {a: 1.0}}}
        connections:
          - First.sum -> Add.a
          - Add.sum -> Second.a
          - Second.execOut -> Last.execIn
        """
    )
    assert run.tick() == ["First 1", "Second 2", "Last 0"]


def test_what_a_node_fires_leads_to_nothing(bench: MakeBench) -> None:
    run = bench(
        """
        evaluator: push
        nodes: {Branch: Branch, Yes: Do, No: Do, Sequence: Sequence, Delay: Delay, Ends: Do}
        connections:
          - Branch.execTrue -> Yes.execIn
          - Branch.execFalse -> No.execIn
          - Sequence.a -> No.execIn
          - Sequence.b -> No.execIn
          - Delay.finished -> Ends.execIn
        """
    )
    assert run.tick() == ["Branch False", "Yes 0", "No 0", "Ends 0"]
    assert run.tick() == ["Branch False", "Yes 0", "No 0", "Ends 0"]


def test_execution_inputs_have_fired_but_for_control_pins(bench: MakeBench) -> None:
    run = bench("evaluator: push\nnodes: {Join: Join, Tick: Tick}\nconnections: [Tick.tick -> Join.hold]")
    assert run.ticks(2) == [["Join first=1 second=1 hold=0"]] * 2
    run.stop()
    assert run.tick() == ["Join first=1 second=1 hold=0"]


def test_a_circle_of_executed_nodes_reads_the_value_of_the_pass_before(bench: MakeBench) -> None:
    run = bench(
        """
        evaluator: push
        nodes: {A: {type: Do, inputs: {b: 1.0}}, B: {type: Do, inputs: {b: 1.0}}}
        connections: [A.sum -> B.a, B.sum -> A.a]
        """
    )
    assert run.codes == ["W104"]
    assert run.ticks(2) == [["A 1", "B 2"], ["A 3", "B 4"]]


def test_a_node_may_read_itself(bench: MakeBench) -> None:
    run = bench("evaluator: push\nnodes: {A: {type: Do, inputs: {b: 1.0}}}\nconnections: [A.sum -> A.a]")
    assert run.ticks(3) == [["A 1"], ["A 2"], ["A 3"]]
    assert run.codes == []


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("nodes: {A: Add, B: Add}\nconnections: [A.sum -> B.a, B.sum -> A.a]", "G209"),
        ("nodes: {A: Do, B: Do}\nconnections: [A.execOut -> B.execIn, B.execOut -> A.execIn]", "G210"),
    ],
)
def test_a_circle_that_has_no_order_is_an_error(file: MakeFile, text: str, code: str) -> None:
    findings = Findings()
    assert planned(file(f"evaluator: push\n{text}"), findings) is None
    assert [found.code for found in findings.errors] == [code]


def test_what_setup_reads_is_known_before_it(bench: MakeBench) -> None:
    run = bench(
        """
        evaluator: push
        nodes: {Text: {type: Text, inputs: {a: scan, b: s}}, Announce: Announce}
        connections: [Text.text -> Announce.topic]
        """
    )
    assert run.journal.read() + run.tick() == ["Announce opens /scans", "Announce sends on /scans"]


def test_a_node_that_raises_leaves_the_others_running(bench: MakeBench) -> None:
    run = bench("evaluator: push\nnodes: {Raise: Raise, Do: Do}", keep_going=True)
    assert run.ticks(2) == [["Do 0"], ["Do 0"]]
    assert len(run.faults) == 1


@pytest.mark.parametrize("name", ["dirty_push", "lazy", "pull"])
def test_other_evaluators_are_refused(file: MakeFile, name: str) -> None:
    findings = Findings()
    planned(file(f"evaluator: {name}\nnodes: {{A: Do}}"), findings)
    (found,) = findings.items
    assert found.code == "G109"
    assert "push" in found.message


def test_nothing_in_a_push_graph_is_told_to_be_idle(file: MakeFile) -> None:
    from graphengine.runtime import check

    findings = Findings()
    graph = planned(file("evaluator: push\nnodes: {A: Do, B: Add}"), findings)
    assert graph is not None
    check.lint_structure(graph, findings)
    assert findings.items == []
    assert rate(graph, 0, 60.0) == 60.0
