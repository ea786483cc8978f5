"""R5, R6: which cycles are errors, and how they are told."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import Findings
from tests.compiler.conftest import MakeBench, MakeFile
from tests.compiler.harness import planned

DATA, EXECUTION = ("G209", "data nodes form a cycle: "), ("G210", "execution wires form a cycle: ")


@pytest.mark.parametrize(
    ("told", "path", "nodes", "circle", "others"),
    [
        (
            DATA,
            "A -> B -> C -> A",
            "A: Add, B: Add, C: Add, Show: Do",
            ["A.sum -> B.a", "B.sum -> C.a", "C.sum -> A.a"],
            ["Tick.tick -> Show.execIn", "C.sum -> Show.a"],
        ),
        (DATA, "A -> A", "A: Add", ["A.sum -> A.a"], []),
        (DATA, "A -> A", "A: Add, B: Constant", ["B.value -> A.a"], ["A.sum -> B.value"]),  # through an input
        (
            EXECUTION,
            "A -> B -> A",
            "A: Do, B: Do",
            ["A.execOut -> B.execIn", "B.execOut -> A.execIn"],
            ["Tick.tick -> A.execIn"],
        ),
        (EXECUTION, "A -> A", "A: Do", ["A.execOut -> A.execIn"], []),
        (
            EXECUTION,
            "ForLoop -> A -> ForLoop",
            "ForLoop: ForLoop, A: Do",
            ["ForLoop.loopBody -> A.execIn", "A.execOut -> ForLoop.execIn"],
            ["Tick.tick -> ForLoop.execIn"],
        ),
    ],
)
def test_r5_r6_a_cycle_is_an_error_printed_whole_with_its_lines(
    file: MakeFile, told: tuple[str, str], path: str, nodes: str, circle: list[str], others: list[str]
) -> None:
    wires = "".join(f"  - {wire}\n" for wire in (*circle, *others))
    findings = Findings()
    assert planned(file(f"graph: g\nnodes: {{Tick: Tick, {nodes}}}\nconnections:\n{wires}"), findings) is None
    (found,) = findings.items
    code, words = told
    assert (found.code, found.message) == (code, words + path)
    assert [(span.line, label) for span, label in found.related] == list(enumerate(circle, 4))
    remedies = {
        "G209": "a node that has an execution input",
        "G210": "a Delay node, or a control input such as `reset`",
    }
    assert found.help == (f"break the cycle with {remedies[code]}",)


@pytest.mark.parametrize(
    ("nodes", "wires", "codes"),
    [
        (
            "A: Do, B: Do, C: Do, D: Do",
            ["A.execOut -> B.execIn", "B.execOut -> A.execIn", "C.execOut -> D.execIn", "D.execOut -> C.execIn"],
            ["G210", "G210"],
        ),
        ("A: Add, B: Do", ["A.sum -> A.a", "B.execOut -> B.execIn"], ["G209", "G210"]),
    ],
)
def test_each_cycle_is_a_finding(file: MakeFile, nodes: str, wires: list[str], codes: list[str]) -> None:
    findings = Findings()
    assert planned(file(f"nodes: {{{nodes}}}\nconnections: [{', '.join(wires)}]"), findings) is None
    assert sorted(found.code for found in findings.items) == codes


def test_r12_a_cycle_through_a_latent_node_is_legal(bench: MakeBench) -> None:
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
