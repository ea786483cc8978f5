"""R5, R6: which cycles are errors, and how they are told."""

from __future__ import annotations

from graphengine.format.diagnostics import Finding, Findings
from tests.compiler.conftest import MakeBench, MakeFile
from tests.compiler.harness import planned


def only_error(file: MakeFile, text: str) -> Finding:
    findings = Findings()
    assert planned(file(text), findings) is None
    (found,) = findings.items
    return found


def test_r5_a_cycle_of_data_nodes_is_an_error_printed_whole_with_its_lines(file: MakeFile) -> None:
    found = only_error(
        file,
        """
        nodes: {Tick: Tick, A: Add, B: Add, C: Add, Show: Do}
        connections:
          - Tick.tick -> Show.execIn
          - A.sum -> B.a
          - B.sum -> C.a
          - C.sum -> A.a
          - C.sum -> Show.a
        """,
    )
    assert (found.code, found.message) == ("G209", "data nodes wait for each other: A -> B -> C -> A")
    assert [(span.line, label) for span, label in found.related] == [
        (5, "A.sum -> B.a"),
        (6, "B.sum -> C.a"),
        (7, "C.sum -> A.a"),
    ]


def test_r5_a_data_node_that_waits_for_itself_is_an_error(file: MakeFile) -> None:
    found = only_error(file, "{nodes: {A: Add}, connections: [A.sum -> A.a], graph: g}")
    assert (found.code, found.message) == ("G209", "data nodes wait for each other: A -> A")


def test_r5_a_cycle_through_an_input_that_hands_on_is_a_cycle(file: MakeFile) -> None:
    found = only_error(
        file,
        """
        nodes: {A: Add, B: Constant}
        connections:
          - A.sum -> B.value
          - B.value -> A.a
        """,
    )
    assert found.code == "G209"


def test_r6_a_cycle_of_execution_is_an_error_printed_whole_with_its_lines(file: MakeFile) -> None:
    found = only_error(
        file,
        """
        nodes: {Tick: Tick, A: Do, B: Do}
        connections:
          - Tick.tick -> A.execIn
          - A.execOut -> B.execIn
          - B.execOut -> A.execIn
        """,
    )
    assert (found.code, found.message) == ("G210", "execution runs in a circle: A -> B -> A")
    assert [span.line for span, _ in found.related] == [5, 6]
    assert found.help == ("break it with a Delay, or a control pin",)


def test_r6_a_node_that_fires_itself_is_an_error(file: MakeFile) -> None:
    found = only_error(file, "{nodes: {A: Do}, connections: [A.execOut -> A.execIn], graph: g}")
    assert (found.code, found.message) == ("G210", "execution runs in a circle: A -> A")


def test_r6_a_cycle_through_a_pusher_is_an_error(file: MakeFile) -> None:
    found = only_error(
        file,
        """
        nodes: {Tick: Tick, ForLoop: ForLoop, A: Do}
        connections:
          - Tick.tick -> ForLoop.execIn
          - ForLoop.loopBody -> A.execIn
          - A.execOut -> ForLoop.execIn
        """,
    )
    assert found.code == "G210"


def test_two_cycles_are_two_findings(file: MakeFile) -> None:
    findings = Findings()
    path = file(
        """
        nodes: {A: Do, B: Do, C: Do, D: Do}
        connections:
          - A.execOut -> B.execIn
          - B.execOut -> A.execIn
          - C.execOut -> D.execIn
          - D.execOut -> C.execIn
        """
    )
    assert planned(path, findings) is None
    assert [found.code for found in findings.items] == ["G210", "G210"]


def test_r12_a_cycle_through_a_latent_node_is_none(bench: MakeBench) -> None:
    run = bench("""
        nodes: {Every: {type: Every, inputs: {n: 100}}, Delay: {type: Delay, inputs: {duration: 0.02}}, A: Do}
        connections:
          - Every.fired -> Delay.execIn
          - Delay.finished -> A.execIn
          - A.execOut -> Delay.execIn
    """)
    run["Every"].n = 1
    run.tick()
    run["Every"].n = 1000
    assert [line for lines in run.ticks(9) for line in lines if line.startswith("A")] == ["A 0"] * 3
